#include "distribute/simulate_eye.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "lightfield/error.h"
#include "lightfield/parallel.h"
#include "lightfield/ray_map.h"

namespace lamella {
namespace {

// On a separable map a pixel's colour is the sum over its column paths and row paths of
//   weight_column * weight_row * emitters[slot_column, slot_row](emitter_column, emitter_row).
struct Path {
  int pixel = 0;
  int slot = 0;
  int emitter = -1;  // -1: beside the panel
  float weight = 0;  // share of the pixel's lines of sight on this axis
};

// One axis of the eye and its picture. Coordinates run with the indices: rows downwards, -y.
struct EyeAxis {
  double eye_mm = 0;
  double start_mm = 0, pixel_mm = 1;
  int pixels = 0;
  double distance_mm = 0;  // from the eye to z = 0

  // Where the line of sight through `at` on z = 0 crosses the plane z.
  double OnPlane(double at, double z) const { return at + (eye_mm - at) * z / distance_mm; }
  double FromPlane(double crossing, double z) const {
    return (crossing - eye_mm * z / distance_mm) / (1 - z / distance_mm);
  }
};

// Places on z = 0, rising, between which all lines of sight of an axis meet the same modulator
// element and emitter and belong to the same pixel.
std::vector<double> Breaks(const EyeAxis& axis, const std::array<double, 2>& planes, int count,
                           double pitch_mm) {
  const double end = axis.start_mm + axis.pixels * axis.pixel_mm;
  std::vector<double> breaks;
  for (int i = 0; i <= axis.pixels; ++i) breaks.push_back(axis.start_mm + i * axis.pixel_mm);
  for (const double z : planes) {
    for (int i = 0; i <= count; ++i) {
      const double at = axis.FromPlane((i - count / 2.0) * pitch_mm, z);
      if (at > axis.start_mm && at < end) breaks.push_back(at);
    }
  }
  std::sort(breaks.begin(), breaks.end());
  return breaks;
}

// What a line of sight meets on one axis, and whether it passes beside the panel.
struct Line {
  std::optional<AxisHit> hit;
  bool beside = false;
};

// The paths of one axis of one layer, sorted by pixel. `line_of(at)` is the line of sight through a
// place on z = 0.
template <class LineOf>
std::vector<Path> AxisPaths(const EyeAxis& axis, const std::vector<double>& breaks,
                            const Barrier& barrier, const LineOf& line_of) {
  std::vector<Path> paths;
  const auto add = [&](int pixel, int slot, int emitter, float weight) {
    for (auto path = paths.rbegin(); path != paths.rend() && path->pixel == pixel; ++path) {
      if (path->slot == slot && path->emitter == emitter) {
        path->weight += weight;
        return;
      }
    }
    paths.push_back({pixel, slot, emitter, weight});
  };
  // Slots in which a line that misses the panel would have met an opening, in the mean.
  const float mean_open = static_cast<float>(barrier.slots * barrier.aperture_px) /
                          static_cast<float>(barrier.period_px);
  for (std::size_t i = 0; i + 1 < breaks.size(); ++i) {
    const double at = (breaks[i] + breaks[i + 1]) / 2;
    const int pixel =
        std::clamp(static_cast<int>((at - axis.start_mm) / axis.pixel_mm), 0, axis.pixels - 1);
    const float share = static_cast<float>((breaks[i + 1] - breaks[i]) / axis.pixel_mm);
    const Line line = line_of(at);
    if (line.beside) add(pixel, 0, -1, share * mean_open);
    if (!line.hit) continue;
    for (int slot = 0; slot < barrier.slots; ++slot) {
      if ((line.hit->open_slots >> slot & 1U) != 0) add(pixel, slot, line.hit->emitter, share);
    }
  }
  return paths;
}

struct LayerPaths {
  std::vector<Path> columns, rows;
  std::vector<std::size_t> first_row;  // of each pixel row in `rows`, and the end
};

LayerPaths PathsOfLayer(const Display& display, int layer, const Eye& eye) {
  const RayMap map(display, layer);
  const Barrier& barrier = BarrierOf(display, static_cast<std::size_t>(layer));
  const double z = map.position_mm(), z_emitters = z - map.d0_mm(), d = eye.position.z();
  const double pitch = display.emitter_pitch_mm();
  const auto paths_of = [&](const EyeAxis& axis, int count, const auto& seen) {
    const double half_width = count * pitch / 2;
    return AxisPaths(axis, Breaks(axis, {z, z_emitters}, count, pitch), barrier, [&](double at) {
      return Line{seen(axis.OnPlane(at, z), (axis.eye_mm - at) / d),
                  std::abs(axis.OnPlane(at, z)) >= half_width ||
                      std::abs(axis.OnPlane(at, z_emitters)) >= half_width};
    });
  };
  LayerPaths paths;
  paths.columns =
      paths_of({eye.position.x(), eye.left_mm, eye.pixel_mm, eye.width, d}, map.columns(),
               [&](double at, double slope) { return map.SeenColumn(at, slope); });
  paths.rows = paths_of({-eye.position.y(), -eye.top_mm, eye.pixel_mm, eye.height, d}, map.rows(),
                        [&](double at, double slope) { return map.SeenRow(-at, -slope); });
  for (int y = 0; y <= eye.height; ++y) {
    const auto first = std::lower_bound(paths.rows.begin(), paths.rows.end(), y,
                                        [](const Path& p, int pixel) { return p.pixel < pixel; });
    paths.first_row.push_back(static_cast<std::size_t>(first - paths.rows.begin()));
  }
  return paths;
}

struct Sum {
  Rgb color;
  float known = 0, all = 0;
};

// Adds what one row path of a layer contributes to the pixels of a picture row.
void AddRow(const std::vector<EmitterImage>& slots, const Barrier& barrier,
            const std::vector<Path>& columns, const Path& row, std::vector<Sum>& sums) {
  std::vector<const Rgb*> colors(static_cast<std::size_t>(barrier.slots));
  std::vector<const float*> coverages(colors.size());
  if (row.emitter >= 0) {
    for (std::size_t s = 0; s < colors.size(); ++s) {
      const EmitterImage& image = slots[static_cast<std::size_t>(barrier.slots * row.slot) + s];
      colors[s] = image.color.row(row.emitter);
      coverages[s] = image.coverage.row(row.emitter);
    }
  }
  for (const Path& column : columns) {
    Sum& sum = sums[static_cast<std::size_t>(column.pixel)];
    const float weight = row.weight * column.weight;
    sum.all += weight;
    if (row.emitter < 0 || column.emitter < 0) continue;
    const std::size_t slot = static_cast<std::size_t>(column.slot);
    sum.color += weight * colors[slot][column.emitter];
    sum.known += weight * coverages[slot][column.emitter];
  }
}

void CheckInput(const LayerImages& layers, const Display& display, const Eye& eye) {
  if (layers.slots.size() != display.layers.size()) {
    throw InputError(display.name,
                     fmt::format("has {} layers, the emitter images {}", display.layers.size(),
                                 layers.slots.size()),
                     "run the stage layers again");
  }
  for (std::size_t l = 0; l < display.layers.size(); ++l) {
    const std::size_t k = static_cast<std::size_t>(BarrierOf(display, l).slots);
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
    if (!(eye.position.z() > display.layers[l].position_mm) || !eye.position.allFinite()) {
      throw UsageError("eye",
                       fmt::format("at {:g} mm is not in front of layer {} at {:g} mm",
                                   eye.position.z(), l, display.layers[l].position_mm),
                       "give a larger viewing distance");
    }
  }
}

}  // namespace

RayBundle BundleOfEye(const Eye& eye, int split) {
  RayBundle bundle;
  bundle.centre << eye.position, 1;
  bundle.origin = {eye.left_mm, eye.top_mm, 0};
  bundle.dx = {eye.pixel_mm / split, 0, 0};
  bundle.dy = {0, -eye.pixel_mm / split, 0};
  bundle.width = eye.width * split;
  bundle.height = eye.height * split;
  return bundle;
}

EyePicture SimulateEye(const LayerImages& layers, const Display& display, const Eye& eye) {
  CheckInput(layers, display, eye);
  std::vector<LayerPaths> paths;
  std::vector<float> gains;  // 1 / (slots per layer * (a/P)^2): n cancels the superposition's 1/n
  for (std::size_t l = 0; l < display.layers.size(); ++l) {
    paths.push_back(PathsOfLayer(display, static_cast<int>(l), eye));
    const Barrier& barrier = BarrierOf(display, l);
    const double open =
        static_cast<double>(barrier.slots) * barrier.aperture_px / barrier.period_px;
    gains.push_back(static_cast<float>(1 / (open * open)));
  }
  EyePicture picture{Image<Rgb>(eye.width, eye.height), Image<float>(eye.width, eye.height)};
  ParallelForEach(0, eye.height, [&](std::int64_t y) {
    const int row = static_cast<int>(y);
    std::vector<Sum> sums(static_cast<std::size_t>(eye.width)), layer_sums(sums.size());
    for (std::size_t l = 0; l < paths.size(); ++l) {
      std::fill(layer_sums.begin(), layer_sums.end(), Sum{});
      const LayerPaths& layer = paths[l];
      for (std::size_t r = layer.first_row[static_cast<std::size_t>(row)];
           r < layer.first_row[static_cast<std::size_t>(row) + 1]; ++r) {
        AddRow(layers.slots[l], BarrierOf(display, l), layer.columns, layer.rows[r], layer_sums);
      }
      for (std::size_t x = 0; x < sums.size(); ++x) {
        sums[x].color += gains[l] * layer_sums[x].color;
        sums[x].known += gains[l] * layer_sums[x].known;
        sums[x].all += gains[l] * layer_sums[x].all;
      }
    }
    for (int x = 0; x < eye.width; ++x) {
      const Sum& sum = sums[static_cast<std::size_t>(x)];
      picture.color(x, row) = sum.color;
      picture.coverage(x, row) = sum.all > 0 ? std::min(1.0F, sum.known / sum.all) : 0.0F;
    }
  });
  return picture;
}

double CleanEyeBox(const Display& display) {
  if (!display.shear) return 0;
  double box = std::numeric_limits<double>::infinity();
  for (std::size_t l = 0; l < display.layers.size(); ++l) {
    const Barrier& barrier = BarrierOf(display, l);
    const double half_px = (barrier.period_px - barrier.aperture_px) / 2.0 - 0.5;
    box = std::min(box, half_px * display.emitter_pitch_mm() * display.viewing_distance_mm /
                            display.layers[l].d0_mm);
  }
  return std::max(0.0, box);
}

}  // namespace lamella
