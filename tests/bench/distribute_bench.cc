// How fast rays are distributed, prefiltered and encoded, given the nodes' samples, as a ratio to
// the rate at which this machine copies memory, in the same run and with as many threads.
//
//   distribute_bench [MILLIONS_OF_RAYS ...]
//
// Bytes that count: every sample of every node once per layer, and the emitters' values. A panel of
// paper-two-layer's with as many rays is distributed from samples that lie ready in memory.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstring>
#include <vector>

#include <fmt/format.h>

#include "distribute/displays.h"
#include "distribute/distribute.h"
#include "distribute/emitter_frame.h"
#include "lightfield/parallel.h"

namespace lamella {
namespace {

using Clock = std::chrono::steady_clock;

constexpr double kMemoryGib = 1;  // strips that stay near the caches

double SecondsSince(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

// Bytes a second that all threads together copy from one place to another.
double CopyRate() {
  constexpr std::int64_t kBytes = std::int64_t{512} << 20, kPart = std::int64_t{1} << 22;
  const std::vector<char> from(kBytes, 1);
  std::vector<char> to(kBytes, 2);
  double best = 0;
  for (int i = 0; i < 7; ++i) {
    const Clock::time_point start = Clock::now();
    ParallelForEach(0, kBytes / kPart, [&](std::int64_t part) {
      std::memcpy(to.data() + part * kPart, from.data() + part * kPart, kPart);
    });
    best = std::max(best, static_cast<double>(kBytes) / SecondsSince(start));
  }
  return best;
}

// Samples of a scene in both layers' depths, the same for every node, copied where they are asked
// for; counts time and samples.
class Ready final : public RaySource {
 public:
  Ready(int width, int height) : samples_(width, height) {
    for (int y = 0; y < height; ++y) {
      for (int x = 0; x < width; ++x) {
        RaySample& sample = samples_(x, y);
        sample.color = {0.001F * static_cast<float>(x % 1000), 0.5F, 0.25F};
        sample.z = static_cast<float>((x / 64 + y / 64) % 2 == 0 ? -10 : 6);
        sample.confidence = sample.coverage = 1;
      }
    }
  }
  void Query(const RayBundle& bundle, const Rect& rect,
             ImageSpan<RaySample> samples) const override {
    const Clock::time_point start = Clock::now();
    ParallelForEach(0, rect.height, [&](std::int64_t y) {
      const int row = (rect.y + static_cast<int>(y)) % samples_.height();
      std::copy_n(samples_.row(row), std::min(rect.width, samples_.width()),
                  samples.row(static_cast<int>(y)));
    });
    // Strips ask for rows at their borders twice, which count once.
    if (rect.y == 0) count += static_cast<double>(bundle.width) * bundle.height;
    seconds += SecondsSince(start);
  }
  mutable double count = 0, seconds = 0;

 private:
  Image<RaySample> samples_;
};

void Run(double millions, double copy_rate) {
  Display display = FindDisplay("paper-two-layer");
  const double emitters = millions * 1e6 / 18, scale = std::sqrt(emitters / (1920.0 * 1080));
  display.width_px = std::max(1, static_cast<int>(1920 * scale / 6)) * 6;
  display.height_px = std::max(1, static_cast<int>(1080 * scale / 6)) * 6;
  const double rays = 18.0 * display.width_px * display.height_px;
  const Ready source(display.width_px + 64, display.height_px + 64);
  const PanelResponse response = PanelResponse::Srgb();
  const Clock::time_point start = Clock::now();
  LayersOptions options;
  options.memory_gib = kMemoryGib;
  Distribute(
      source, display, options, {},
      [&](const EmitterRows& rows) {
        Display strip = display;
        strip.height_px = rows.emitters.color.height();
        EmitterFrame(rows.emitters, strip, rows.layer, response);
      },
      SilentProgress());
  const double seconds = SecondsSince(start) - source.seconds;
  const double bytes = 2 * sizeof(RaySample) * source.count + (sizeof(Rgb) + sizeof(float)) * rays;
  fmt::print(
      "{:8.1f} M rays {:5} x {:5} px {:9.3f} s {:7.1f} ns/ray {:7.2f} GB {:6.2f} GB/s "
      "of_copy_rate {:.3f}\n",
      rays / 1e6, display.width_px, display.height_px, seconds, 1e9 * seconds / rays, bytes / 1e9,
      bytes / seconds / 1e9, bytes / seconds / copy_rate);
}

}  // namespace
}  // namespace lamella

int main(int argc, char** argv) {
  std::vector<double> sizes;
  for (int i = 1; i < argc; ++i) sizes.push_back(std::stod(argv[i]));
  if (sizes.empty()) sizes = {1, 3, 10, 30, 100, 300};
  const double copy_rate = lamella::CopyRate();
  fmt::print("copy_rate {:.2f} GB/s\n", copy_rate / 1e9);
  for (const double millions : sizes) lamella::Run(millions, copy_rate);
}
