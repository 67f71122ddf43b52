#include "distribute/one_bit.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <numeric>
#include <optional>
#include <utility>

#include "distribute/blue_noise.h"
#include "distribute/direction_lattice.h"
#include "lightfield/color.h"
#include "lightfield/error.h"
#include "lightfield/lenslet_map.h"
#include "lightfield/parallel.h"
#include "lightfield/varifocal.h"

namespace lamella {
namespace {

constexpr int kMaxStrokes = 4096;
constexpr int kNone = DirectionLattice::kNone;

struct NamedMethod {
  const char* name;
  OneBitMethod method;
};
constexpr std::array kMethods{NamedMethod{"sigma-delta", OneBitMethod::kSigmaDelta},
                              NamedMethod{"ordered", OneBitMethod::kOrdered},
                              NamedMethod{"diffusion", OneBitMethod::kDiffusion}};

// One direction of one plane: a picture with a pixel per lens.
struct Picture {
  const DirectionLattice* lattice = nullptr;
  int plane = 0, direction = 0;
  Image<float> grey;   // 0 where there is no emitter
  Image<float> noise;  // blue, in (0, 1)

  const Image<int>& emitters() const {
    return lattice->emitters[static_cast<std::size_t>(direction)];
  }
};

enum class NoiseUse { kRounding, kTime };  // the second is independent of the first

// A well mixed number (SplitMix64's finaliser).
std::uint64_t Mix(int plane, int direction, NoiseUse use) {
  std::uint64_t z = static_cast<std::uint64_t>(plane) << 32U;
  z += (use == NoiseUse::kTime ? std::uint64_t{1} << 31U : 0U) + std::uint64_t(direction) + 1;
  z *= 0x9E3779B97F4A7C15U;
  z = (z ^ (z >> 30U)) * 0xBF58476D1CE4E5B9U;
  z = (z ^ (z >> 27U)) * 0x94D049BB133111EBU;
  return z ^ (z >> 31U);
}

// The tile of blue noise laid over the lenses, for every plane and direction from another place, so
// that neighbours on the panel do not pulse together.
Image<float> NoiseOver(const DirectionLattice& lattice, int plane, int direction, NoiseUse use) {
  const Image<float>& tile = BlueNoise(lattice.lenses.lattice);
  const std::uint64_t mixed = Mix(plane, direction, use);
  constexpr int kSize = kBlueNoiseSize;
  const int right = static_cast<int>(mixed % kSize);
  // By whole pairs of rows, and so that the tile's odd rows lie on shifted ones.
  const int parity = lattice.lenses.shift_odd_rows ? 0 : 1;
  const int down = static_cast<int>(mixed / kSize % (kSize / 2)) * 2 + parity;
  const auto wrap = [](int i) { return ((i % kSize) + kSize) % kSize; };
  Image<float> noise(lattice.columns, lattice.rows);
  for (int y = 0; y < lattice.rows; ++y) {
    for (int x = 0; x < lattice.columns; ++x) {
      noise(x, y) =
          tile(wrap(lattice.first_column + x + right), wrap(lattice.first_row + y + down));
    }
  }
  return noise;
}

Picture PictureOf(const DirectionLattice& lattice, const Image<float>& grey, int plane,
                  int direction) {
  Picture picture{&lattice, plane, direction, Image<float>(lattice.columns, lattice.rows),
                  NoiseOver(lattice, plane, direction, NoiseUse::kRounding)};
  const int* emitter = picture.emitters().data();
  for (std::size_t i = 0; i < picture.grey.size(); ++i) {
    picture.grey.data()[i] = emitter[i] == kNone ? 0.0F : grey.data()[emitter[i]];
  }
  return picture;
}

// Lights the emitter of lens i. Tasks own directions, so no two write one emitter's bits.
void LightUp(const Picture& picture, std::size_t i, Image<std::uint32_t>& stroke) {
  stroke.data()[picture.emitters().data()[i]] |= 1U << static_cast<unsigned>(picture.plane);
}

// Blue noise for when in time an emitter's strokes come.
Image<float> TimesOf(const Picture& picture) {
  return NoiseOver(*picture.lattice, picture.plane, picture.direction, NoiseUse::kTime);
}

// 0 ... count - 1 so that any first part of it is spread evenly: by the binary digits of the place
// mirrored at the point (van der Corput).
std::vector<int> SpreadOrder(int count) {
  const auto mirrored = [](int t) {
    double value = 0;
    for (double digit = 0.5; t > 0; t /= 2, digit /= 2) value += t % 2 == 1 ? digit : 0.0;
    return value;
  };
  std::vector<int> places(static_cast<std::size_t>(count)), order(places.size());
  std::iota(places.begin(), places.end(), 0);
  std::sort(places.begin(), places.end(), [&](int a, int b) { return mirrored(a) < mirrored(b); });
  for (std::size_t rank = 0; rank < places.size(); ++rank) {
    order[static_cast<std::size_t>(places[rank])] = static_cast<int>(rank);
  }
  return order;
}

void Ordered(const Picture& picture, std::vector<Image<std::uint32_t>>& strokes) {
  const Image<float> times = TimesOf(picture);
  const std::size_t count = strokes.size();
  const std::vector<int> order = SpreadOrder(static_cast<int>(count));
  for (std::size_t i = 0; i < picture.grey.size(); ++i) {
    const float wanted = picture.grey.data()[i] * static_cast<float>(count);
    if (!(wanted > 0)) continue;
    const auto start = static_cast<std::size_t>(times.data()[i] * static_cast<float>(count));
    for (std::size_t t = 0; t < count; ++t) {
      const auto step = static_cast<float>(order[(t + start) % count]);
      if (wanted > step + picture.noise.data()[i]) LightUp(picture, i, strokes[t]);
    }
  }
}

// `sums`: where they start, and on return where they ended.
void SigmaDeltaStrokes(const Picture& picture, std::vector<Image<std::uint32_t>>& strokes,
                       Image<double>& sums) {
  for (std::size_t i = 0; i < picture.grey.size(); ++i) {
    const auto grey = static_cast<double>(picture.grey.data()[i]);
    if (!(grey > 0)) continue;
    for (Image<std::uint32_t>& stroke : strokes) {
      if (SigmaDelta(grey, sums.data()[i])) LightUp(picture, i, stroke);
    }
  }
}

// Where errors go, from lens (x, y): only to lenses whose emitter is neither black nor full, which
// stay as they are.
struct Receiver {
  int x = 0, y = 0;
  float weight = 0;
};
std::vector<Receiver> ReceiversOf(const Picture& picture, int x, int y) {
  std::vector<Receiver> receivers;
  const auto add = [&](int to_x, int to_y, float weight) {
    const DirectionLattice& lattice = *picture.lattice;
    if (to_x < 0 || to_x >= lattice.columns || to_y >= lattice.rows) return;
    const float grey = picture.grey(to_x, to_y);
    if (grey > 0 && grey < 1) receivers.push_back({to_x, to_y, weight});
  };
  add(x + 1, y, 7);
  if (picture.lattice->lenses.lattice == LensletArray::Lattice::kSquare) {
    add(x - 1, y + 1, 3);
    add(x, y + 1, 5);
    add(x + 1, y + 1, 1);
  } else {
    const auto [left, right] = picture.lattice->BelowHexagonal(y);
    add(x + left, y + 1, 4.5F);
    add(x + right, y + 1, 4.5F);
  }
  float sum = 0;
  for (const Receiver& receiver : receivers) sum += receiver.weight;
  for (Receiver& receiver : receivers) receiver.weight /= sum;
  return receivers;
}

// `on` strokes of all, evenly, from a start in [0, 1).
void Spread(const Picture& picture, std::size_t i, int on, float start,
            std::vector<Image<std::uint32_t>>& strokes) {
  const auto count = static_cast<int>(strokes.size());
  int sum = static_cast<int>(start * static_cast<float>(count));
  for (Image<std::uint32_t>& stroke : strokes) {
    sum += on;
    if (sum < count) continue;
    sum -= count;
    LightUp(picture, i, stroke);
  }
}

void Diffusion(const Picture& picture, std::vector<Image<std::uint32_t>>& strokes) {
  // Of what a lens gets, strokes: more only comes where rims leave fewer lenses to give errors to.
  constexpr float kLimit = 0.5;
  const auto count = static_cast<float>(strokes.size());
  const Image<float> times = TimesOf(picture);
  Image<float> errors(picture.grey.width(), picture.grey.height());
  for (int y = 0; y < errors.height(); ++y) {
    for (int x = 0; x < errors.width(); ++x) {
      const float grey = picture.grey(x, y);
      if (!(grey > 0)) continue;
      const float wanted = grey * count + std::clamp(errors(x, y), -kLimit, kLimit);
      const float on = std::clamp(std::floor(wanted + 0.5F), 0.0F, count);
      const auto i = static_cast<std::size_t>(picture.grey.row(y) - picture.grey.data() + x);
      Spread(picture, i, static_cast<int>(on), times(x, y), strokes);
      if (grey >= 1) continue;
      const float error = wanted - on;
      for (const Receiver& to : ReceiversOf(picture, x, y)) errors(to.x, to.y) += error * to.weight;
    }
  }
}

// One direction through all planes, from the back to the front.
class Chain {
 public:
  explicit Chain(const Display& display) : display_(display) {}

  // Sums for a plane: blue noise, or the ends of the plane behind where that shows the same ray.
  Image<double> Start(const Picture& picture) const {
    Image<double> sums(picture.grey.width(), picture.grey.height());
    for (std::size_t i = 0; i < sums.size(); ++i) {
      sums.data()[i] = static_cast<double>(picture.noise.data()[i]);
    }
    if (behind_.lattice == nullptr) return sums;
    const LensletMap map(display_, picture.plane);
    for (std::size_t i = 0; i < sums.size(); ++i) {
      if (!(picture.grey.data()[i] > 0)) continue;
      if (const double* end = EndBehind(map, picture, picture.emitters().data()[i])) {
        sums.data()[i] = *end;
      }
    }
    return sums;
  }

  void Add(Picture picture, Image<double> ends) {
    behind_ = std::move(picture);
    ends_ = std::move(ends);
  }

 private:
  // At the lens of the plane behind that the emitter's ray passes, in the same direction.
  const double* EndBehind(const LensletMap& map, const Picture& picture, int emitter) const {
    const int columns = display_.emitter_columns(), rows = display_.emitter_rows();
    const Layer& back = display_.layers[static_cast<std::size_t>(behind_.plane)];
    const Layer& front = display_.layers[static_cast<std::size_t>(picture.plane)];
    const std::optional<Beam> beam = map.BeamOf(emitter % columns, emitter / columns);
    if (!beam) return nullptr;
    const double offset = back.position_mm - front.position_mm;
    const double pitch = display_.emitter_pitch_mm(back);
    const DirectionLattice& lattice = *behind_.lattice;
    const Lens lens = NearestLens(lattice.lenses, beam->x.At(offset) / pitch + columns / 2.0,
                                  rows / 2.0 - beam->y.At(offset) / pitch);
    const int x = lens.column - lattice.first_column, y = lens.row - lattice.first_row;
    if (x < 0 || x >= lattice.columns || y < 0 || y >= lattice.rows) return nullptr;
    return behind_.grey(x, y) > 0 ? &ends_(x, y) : nullptr;
  }

  const Display& display_;
  Picture behind_;  // without a lattice at the first plane
  Image<double> ends_;
};

void CheckInput(const std::vector<Image<float>>& grey, const Display& display,
                const OneBitOptions& options) {
  if (display.layers.empty() || display.layers.size() > kMaxBitPlanes) {
    throw UsageError(display.name,
                     std::to_string(display.layers.size()) + " planes of one bit in a frame",
                     "use a display of 1 to " + std::to_string(kMaxBitPlanes) + " planes");
  }
  if (options.strokes < 1 || options.strokes > kMaxStrokes) {
    throw UsageError("strokes", std::to_string(options.strokes) + " is out of range",
                     "use 1 to " + std::to_string(kMaxStrokes));
  }
  const bool fits = grey.size() == display.layers.size() &&
                    std::all_of(grey.begin(), grey.end(), [&](const Image<float>& plane) {
                      return plane.width() == display.emitter_columns() &&
                             plane.height() == display.emitter_rows();
                    });
  if (!fits) {
    throw UsageError(display.name, "the pictures are not those of its planes",
                     "make the layers again for this display");
  }
}

}  // namespace

std::vector<std::string> OneBitMethodNames() {
  std::vector<std::string> names;
  for (const NamedMethod& method : kMethods) names.emplace_back(method.name);
  return names;
}

OneBitMethod OneBitMethodOf(std::string_view name) {
  for (const NamedMethod& method : kMethods) {
    if (method.name == name) return method.method;
  }
  throw UsageError("one-bit method", "there is no \"" + std::string(name) + "\"",
                   "did you mean \"" + NearestName(name, OneBitMethodNames()) + "\"?");
}

Image<float> GreyOf(const EmitterImage& emitters) {
  Image<float> grey(emitters.color.width(), emitters.color.height());
  for (std::size_t i = 0; i < grey.size(); ++i) {
    if (!(emitters.coverage.data()[i] > 0)) continue;
    const Rgb& light = emitters.color.data()[i];
    const float y = Luminance(light);
    grey.data()[i] = y > 0 ? std::min(y, 1.0F) : 0.0F;  // NaN is 0
  }
  return grey;
}

BitPlanes OneBitPlanes(const std::vector<Image<float>>& grey, const Display& display,
                       const OneBitOptions& options) {
  CheckInput(grey, display, options);
  const int planes = static_cast<int>(grey.size());
  const auto lattices = DirectionsOfAll(display);
  BitPlanes bits{planes, {}};
  for (int t = 0; t < options.strokes; ++t) {
    bits.strokes.emplace_back(display.emitter_columns(), display.emitter_rows());
  }
  int directions = 0;
  for (const auto& lattice : lattices) {
    directions = std::max(directions, lattice->directions());
  }
  ParallelForEach(0, directions, [&](std::int64_t d) {
    const int direction = static_cast<int>(d);
    Chain chain(display);
    for (int plane = 0; plane < planes; ++plane) {
      const DirectionLattice& lattice = *lattices[static_cast<std::size_t>(plane)];
      if (direction >= lattice.directions()) continue;
      Picture picture = PictureOf(lattice, grey[static_cast<std::size_t>(plane)], plane, direction);
      switch (options.method) {
        case OneBitMethod::kOrdered:
          Ordered(picture, bits.strokes);
          break;
        case OneBitMethod::kDiffusion:
          Diffusion(picture, bits.strokes);
          break;
        case OneBitMethod::kSigmaDelta: {
          Image<double> sums = chain.Start(picture);
          SigmaDeltaStrokes(picture, bits.strokes, sums);
          if (options.couple_planes) chain.Add(std::move(picture), std::move(sums));
          break;
        }
      }
    }
  });
  return bits;
}

Image<float> MeanOfStrokes(const BitPlanes& bits, int plane) {
  Image<float> mean(bits.strokes.at(0).width(), bits.strokes.at(0).height());
  for (std::size_t i = 0; i < mean.size(); ++i) {
    int on = 0;
    for (const Image<std::uint32_t>& stroke : bits.strokes) {
      on += static_cast<int>(stroke.data()[i] >> static_cast<unsigned>(plane) & 1U);
    }
    mean.data()[i] = static_cast<float>(on) / static_cast<float>(bits.strokes.size());
  }
  return mean;
}

}  // namespace lamella
