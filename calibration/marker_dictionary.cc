#include "calibration/marker_dictionary.h"

#include <algorithm>
#include <bit>
#include <random>
#include <utility>
#include <vector>

namespace lamella {
namespace {

constexpr int kBits = kMarkerModules * kMarkerModules;
constexpr int kLeastDistance = 7;
constexpr int kMostErrors = 2;  // less than half of that, and a wide berth for what is no marker
constexpr int kNumTurns = 8;

using Turned = std::array<MarkerBits, kNumTurns>;

MarkerTurn TurnOf(int t) { return {t % 4, t >= 4}; }

// Where module (i, j) of a marker that lies so stands in the frame.
std::pair<int, int> ModuleInFrame(int i, int j, const MarkerTurn& turn) {
  if (turn.mirrored) std::swap(i, j);
  for (int r = 0; r < turn.turns; ++r) {
    const int old = i;
    i = kMarkerModules - 1 - j;
    j = old;
  }
  return {i, j};
}

// What is read in the frame of a marker that lies so.
MarkerBits Read(MarkerBits bits, const MarkerTurn& turn) {
  MarkerBits read = 0;
  for (int j = 0; j < kMarkerModules; ++j) {
    for (int i = 0; i < kMarkerModules; ++i) {
      const auto [x, y] = ModuleInFrame(i, j, turn);
      const MarkerBits bit = bits >> static_cast<unsigned>(i + kMarkerModules * j) & 1U;
      read |= bit << static_cast<unsigned>(x + kMarkerModules * y);
    }
  }
  return read;
}

Turned AllTurns(MarkerBits bits) {
  Turned turned{};
  for (int t = 0; t < kNumTurns; ++t) turned[static_cast<std::size_t>(t)] = Read(bits, TurnOf(t));
  return turned;
}

int Distance(MarkerBits a, MarkerBits b) { return std::popcount(a ^ b); }

bool IsFarFromItself(const Turned& turned) {
  return std::all_of(turned.begin() + 1, turned.end(), [&](MarkerBits other) {
    return Distance(turned[0], other) >= kLeastDistance;
  });
}

// Random words, each kept if it is far from all before it. The generator's numbers are those of the
// C++ standard, so that the markers are the same everywhere.
std::vector<Turned> MakeDictionary() {
  std::mt19937_64 random(1);
  std::vector<Turned> dictionary;
  while (dictionary.size() < kNumMarkers) {
    const Turned turned = AllTurns(random() >> (64 - kBits));
    if (!IsFarFromItself(turned)) continue;
    const bool far = std::all_of(dictionary.begin(), dictionary.end(), [&](const Turned& other) {
      return std::all_of(turned.begin(), turned.end(), [&](MarkerBits bits) {
        return Distance(bits, other[0]) >= kLeastDistance;
      });
    });
    if (far) dictionary.push_back(turned);
  }
  return dictionary;
}

const std::vector<Turned>& Dictionary() {
  static const std::vector<Turned> dictionary = MakeDictionary();
  return dictionary;
}

}  // namespace

MarkerBits BitsOfMarker(int id) { return Dictionary().at(static_cast<std::size_t>(id))[0]; }

std::optional<KnownMarker> FindMarker(MarkerBits read) {
  const auto& dictionary = Dictionary();
  for (std::size_t id = 0; id < dictionary.size(); ++id) {
    for (int t = 0; t < kNumTurns; ++t) {
      if (Distance(read, dictionary[id][static_cast<std::size_t>(t)]) <= kMostErrors) {
        return KnownMarker{static_cast<int>(id), TurnOf(t)};
      }
    }
  }
  return std::nullopt;
}

}  // namespace lamella
