// Panel images from codes: the photometric half of the virtual prototype.
#include <array>
#include <cmath>
#include <memory>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "datasets_synthetic/prototype.h"
#include "lightfield/error.h"
#include "lightfield/parallel.h"

namespace lamella {
namespace {

// black + (1 - black) curve(code) of all 8-bit codes.
std::array<float, 256> Levels(const Photometry& photometry) {
  std::array<float, 256> levels{};
  for (std::size_t code = 0; code < levels.size(); ++code) {
    const double light = LightOfCode(photometry.curve, static_cast<double>(code) / 255);
    levels[code] = static_cast<float>(photometry.black + (1 - photometry.black) * light);
  }
  return levels;
}

void CheckSize(const PanelCalibration& panel, ImageSpan<const Rgb8> codes) {
  if (codes.width == panel.width_px && codes.height == panel.height_px) return;
  throw InputError("",
                   fmt::format("an image of {} x {} px is shown on a panel of {} x {}", codes.width,
                               codes.height, panel.width_px, panel.height_px),
                   "give images of the panel's pixels");
}

// Every pixel's light is handed out by the kernel; what leaves the panel is lost.
Image<Rgb> Spread(const Image<Rgb>& light, const SpreadKernel& kernel) {
  Image<Rgb> spread(light.width(), light.height());
  const int half = kernel.size / 2;
  ParallelForEach(0, light.height(), [&](std::int64_t row) {
    const int y = static_cast<int>(row);
    for (int x = 0; x < light.width(); ++x) {
      Rgb sum;
      for (int dy = -half; dy <= half; ++dy) {
        for (int dx = -half; dx <= half; ++dx) {
          // The pixel at (x - dx, y - dy) gives to the one that is (dx, dy) further.
          const int u = x - dx, v = y - dy;
          if (u < 0 || v < 0 || u >= light.width() || v >= light.height()) continue;
          const int index = (dy + half) * kernel.size + dx + half;
          const double weight = kernel.weights[static_cast<std::size_t>(index)];
          sum += static_cast<float>(weight) * light(u, v);
        }
      }
      spread(x, y) = sum;
    }
  });
  return spread;
}

template <class T>
std::vector<std::shared_ptr<const Image<T>>> Late(
    const std::vector<std::shared_ptr<const Image<T>>>& slots, const std::vector<int>& order,
    float crosstalk) {
  std::vector<std::shared_ptr<const Image<T>>> late(slots.size());
  for (std::size_t t = 0; t < slots.size(); ++t) {
    const auto slot = static_cast<std::size_t>(order[t]);
    const Image<T>& now = *slots[slot];
    const Image<T>& before =
        *slots[static_cast<std::size_t>(order[(t + slots.size() - 1) % slots.size()])];
    auto mixed = std::make_shared<Image<T>>(now.width(), now.height());
    for (std::size_t i = 0; i < now.size(); ++i) {
      mixed->data()[i] = (1 - crosstalk) * now.data()[i] + crosstalk * before.data()[i];
    }
    late[slot] = std::move(mixed);
  }
  return late;
}

}  // namespace

ShownLayer WithSlotCrosstalk(const ShownLayer& shown, const std::vector<int>& order,
                             double crosstalk) {
  const auto share = static_cast<float>(crosstalk);
  return {Late(shown.emitter, order, share), Late(shown.modulator, order, share)};
}

Image<Rgb> LightOfEmitter(const PanelCalibration& panel, ImageSpan<const Rgb8> codes) {
  CheckSize(panel, codes);
  const std::array<float, 256> levels = Levels(panel.photometry);
  const Eigen::Matrix3f primaries = panel.photometry.primaries.cast<float>();
  const bool plain = panel.rgb_stripes ||  // whose colours mix in the eye
                     panel.photometry.primaries == Eigen::Matrix3d::Identity();
  const GainMap& evenness = panel.photometry.evenness;
  const bool even = evenness == GainMap();
  Image<Rgb> light(codes.width, codes.height);
  for (int y = 0; y < codes.height; ++y) {
    for (int x = 0; x < codes.width; ++x) {
      const Rgb8 code = codes(x, y);
      Rgb own{levels[code.r], levels[code.g], levels[code.b]};
      if (!plain) {
        const Eigen::Vector3f mixed = primaries * Eigen::Vector3f(own.r, own.g, own.b);
        own = {mixed.x(), mixed.y(), mixed.z()};
      }
      if (!even) {
        own = static_cast<float>(
                  GainAt(evenness, (x + 0.5) / codes.width, (y + 0.5) / codes.height)) *
              own;
      }
      light(x, y) = own;
    }
  }
  if (panel.photometry.crosstalk.size == 1) return light;
  return Spread(light, panel.photometry.crosstalk);
}

Image<float> TransmittanceOfModulator(const PanelCalibration& panel, ImageSpan<const Rgb8> codes) {
  CheckSize(panel, codes);
  const std::array<float, 256> levels = Levels(panel.photometry);
  Image<float> transmittance(codes.width, codes.height);
  for (int y = 0; y < codes.height; ++y) {
    for (int x = 0; x < codes.width; ++x) transmittance(x, y) = levels[codes(x, y).g];
  }
  return transmittance;
}

}  // namespace lamella
