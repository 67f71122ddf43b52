#include "distribute/simulate_eye.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <numbers>
#include <optional>
#include <vector>

#include <fmt/format.h>

#include "distribute/analyze.h"
#include "distribute/seen_layer.h"
#include "lightfield/error.h"
#include "lightfield/parallel.h"

namespace lamella {
namespace {

void CheckImages(const LayerImages& layers, const Display& display) {
  if (layers.slots.size() != display.layers.size()) {
    throw InputError(display.name,
                     fmt::format("has {} layers, the emitter images {}", display.layers.size(),
                                 layers.slots.size()),
                     "run the stage layers again");
  }
  for (std::size_t l = 0; l < display.layers.size(); ++l) {
    const auto k = static_cast<std::size_t>(SlotsPerAxis(display.layers[l]));
    if (layers.slots[l].size() != k * k) {
      throw InputError(display.name,
                       fmt::format("layer {} has {} slots, the emitter images {}", l, k * k,
                                   layers.slots[l].size()),
                       "run the stage layers again");
    }
    for (const EmitterImage& image : layers.slots[l]) {
      if (image.color.width() != display.emitter_columns() ||
          image.color.height() != display.emitter_rows() ||
          image.coverage.width() != image.color.width() ||
          image.coverage.height() != image.color.height()) {
        throw InputError(display.name,
                         fmt::format("an emitter image of layer {} is not {} x {}", l,
                                     display.emitter_columns(), display.emitter_rows()),
                         "run the stage layers again");
      }
    }
  }
}

EyePicture SimulatePinhole(const EmitterStrip& strip, const Display& display, const Eye& eye,
                           const RowRange& rows) {
  std::vector<std::unique_ptr<LayerSeen>> seen(display.layers.size());
  ParallelForEach(0, static_cast<std::int64_t>(seen.size()), [&](std::int64_t layer) {
    seen[static_cast<std::size_t>(layer)] =
        SeeLayer(strip, display, static_cast<int>(layer), eye, rows);
  });
  EyePicture picture{Image<Rgb>(eye.width, rows.size()), Image<float>(eye.width, rows.size())};
  ParallelForEach(0, (rows.size() + kPictureBandRows - 1) / kPictureBandRows, [&](std::int64_t b) {
    const int first = rows.first + static_cast<int>(b) * kPictureBandRows;
    const int end = std::min(first + kPictureBandRows, rows.end);
    PictureRows band{first, end, Image<Seen>(eye.width, end - first)};
    for (const std::unique_ptr<LayerSeen>& layer : seen) layer->Add(band);
    for (int y = first; y < end; ++y) {
      for (int x = 0; x < eye.width; ++x) {
        const Seen& sum = band.sums(x, y - first);
        picture.color(x, y - rows.first) = {static_cast<float>(sum.r), static_cast<float>(sum.g),
                                            static_cast<float>(sum.b)};
        picture.coverage(x, y - rows.first) =
            sum.all > 0 ? static_cast<float>(std::min(1.0, sum.known / sum.all)) : 0.0F;
      }
    }
  });
  return picture;
}

}  // namespace

RayBundle BundleOfEye(const Eye& eye, int split) {
  RayBundle bundle;
  bundle.centre << eye.position, 1;
  bundle.origin = {eye.left_mm, eye.top_mm, eye.plane_mm};
  bundle.dx = {eye.pixel_mm / split, 0, 0};
  bundle.dy = {0, -eye.pixel_mm / split, 0};
  bundle.width = eye.width * split;
  bundle.height = eye.height * split;
  return bundle;
}

std::vector<Eye> PupilSamples(const Eye& eye, const Pupil& pupil) {
  const double golden_angle = std::numbers::pi * (3 - std::sqrt(5.0));
  std::vector<Eye> samples(static_cast<std::size_t>(pupil.samples), eye);
  for (int i = 0; i < pupil.samples; ++i) {
    const double radius = pupil.diameter_mm / 2 * std::sqrt((i + 0.5) / pupil.samples);
    Eigen::Vector3d& position = samples[static_cast<std::size_t>(i)].position;
    position.x() += radius * std::cos(i * golden_angle);
    position.y() += radius * std::sin(i * golden_angle);
  }
  return samples;
}

void CheckEye(const Display& display, const Eye& eye) {
  for (std::size_t l = 0; l < display.layers.size(); ++l) {
    if (!(eye.position.z() > std::max(eye.plane_mm, display.layers[l].position_mm)) ||
        !eye.position.allFinite()) {
      throw UsageError("eye",
                       fmt::format("at {:g} mm is not in front of layer {} at {:g} mm",
                                   eye.position.z(), l, display.layers[l].position_mm),
                       "give a larger viewing distance");
    }
  }
}

EyePicture SimulateRows(const EmitterStrip& strip, const Display& display, const Eye& eye,
                        const std::optional<Pupil>& pupil, const RowRange& rows) {
  if (!pupil) return SimulatePinhole(strip, display, eye, rows);
  EyePicture mean{Image<Rgb>(eye.width, rows.size()), Image<float>(eye.width, rows.size())};
  const float weight = 1.0F / static_cast<float>(pupil->samples);
  for (const Eye& sample : PupilSamples(eye, *pupil)) {
    const EyePicture picture = SimulatePinhole(strip, display, sample, rows);
    for (std::size_t i = 0; i < mean.color.size(); ++i) {
      mean.color.data()[i] += weight * picture.color.data()[i];
      mean.coverage.data()[i] += weight * picture.coverage.data()[i];
    }
  }
  return mean;
}

EmitterStrip WholeStrip(const LayerImages& layers, const Display& display) {
  CheckImages(layers, display);
  return StripOf(layers, std::vector<int>(display.layers.size()), display);
}

EyePicture SimulateEye(const LayerImages& layers, const Display& display, const Eye& eye,
                       const std::optional<Pupil>& pupil) {
  const EmitterStrip strip = WholeStrip(layers, display);
  CheckEye(display, eye);
  return SimulateRows(strip, display, eye, pupil, {0, eye.height});
}

double CleanEyeBox(const Display& display) {
  double box = std::numeric_limits<double>::infinity();
  for (const Layer& layer : display.layers) {
    const EyeRectangle of = CleanEyeBoxOf(display, layer);
    box = std::min({box, of.x_mm, of.y_mm});
  }
  return box;
}

}  // namespace lamella