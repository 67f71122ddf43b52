// Layers whose optics are a product of two axes: openings of a barrier, or none.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "distribute/encode_barrier.h"
#include "distribute/seen_layer.h"
#include "lightfield/ray_map.h"

namespace lamella {
namespace {

// On a separable map a pixel's colour is the sum over its column paths and row paths of
//   weight_column * weight_row * emitters[slot_column, slot_row](emitter_column, emitter_row).
struct Path {
  int pixel = 0;
  int slot = 0;
  int emitter = -1;   // -1: beside the panel
  double weight = 0;  // share of the pixel's lines of sight on this axis
};

// One axis of the eye and its picture. Coordinates run with the indices: rows downwards, -y.
struct EyeAxis {
  double eye_mm = 0;
  double start_mm = 0, pixel_mm = 1;
  int pixels = 0;
  double plane_mm = 0;     // z of the picture
  double distance_mm = 0;  // from the eye to it

  // Where the line of sight through `at` on the picture crosses the plane z.
  double OnPlane(double at, double z) const { return at + (eye_mm - at) * Share(z); }
  double FromPlane(double crossing, double z) const {
    return (crossing - eye_mm * Share(z)) / (1 - Share(z));
  }

 private:
  double Share(double z) const { return (z - plane_mm) / distance_mm; }
};

// Places on the picture, rising, between which all lines of sight of an axis meet the same
// modulator element and emitter and belong to the same pixel.
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

// Which lines of sight are followed: those through openings, slot by slot, or all through the
// modulator's whole face, as of one slot.
enum class Through { kOpenings, kFace };

// The paths of one axis of one layer, sorted by pixel. `line_of(at)` is the line of sight through a
// place on the picture.
template <class LineOf>
std::vector<Path> AxisPaths(const EyeAxis& axis, const std::vector<double>& breaks,
                            const Barrier& barrier, Through through, const LineOf& line_of) {
  std::vector<Path> paths;
  const auto add = [&](int pixel, int slot, int emitter, double weight) {
    for (auto path = paths.rbegin(); path != paths.rend() && path->pixel == pixel; ++path) {
      if (path->slot == slot && path->emitter == emitter) {
        path->weight += weight;
        return;
      }
    }
    paths.push_back({pixel, slot, emitter, weight});
  };
  // Slots in which a line that misses the panel would have met an opening, in the mean.
  const double mean_open = through == Through::kFace ? 1
                                                     : static_cast<double>(barrier.slots) *
                                                           barrier.aperture_px / barrier.period_px;
  for (std::size_t i = 0; i + 1 < breaks.size(); ++i) {
    const double at = (breaks[i] + breaks[i + 1]) / 2;
    const int pixel =
        std::clamp(static_cast<int>((at - axis.start_mm) / axis.pixel_mm), 0, axis.pixels - 1);
    const double share = (breaks[i + 1] - breaks[i]) / axis.pixel_mm;
    const Line line = line_of(at);
    if (line.beside) add(pixel, 0, -1, share * mean_open);
    if (!line.hit) continue;
    if (through == Through::kFace) {
      add(pixel, 0, line.hit->emitter, share);
      continue;
    }
    for (int slot = 0; slot < barrier.slots; ++slot) {
      if ((line.hit->open_slots >> slot & 1U) != 0) add(pixel, slot, line.hit->emitter, share);
    }
  }
  return paths;
}

// The paths of one layer.
struct LayerPaths {
  std::vector<Path> columns, rows;
  std::vector<std::size_t> first_row;  // of each pixel row in `rows`, and the end
};

// Both axes of a layer before an eye.
class LayerAxes {
 public:
  LayerAxes(const Display& display, int layer, const Eye& eye, Through through)
      : map_(display, layer),
        barrier_(OpeningsOf(display.layers[static_cast<std::size_t>(layer)])),
        eye_(eye),
        pitch_mm_(display.emitter_pitch_mm(display.layers[static_cast<std::size_t>(layer)])),
        through_(through) {}

  std::vector<Path> Columns() const {
    const Eigen::Vector3d& at = eye_.position;
    return PathsOf({at.x(), eye_.left_mm, eye_.pixel_mm, eye_.width, eye_.plane_mm, Distance()},
                   map_.columns(),
                   [&](double x, double slope) { return map_.MetColumn(x, slope); });
  }
  std::vector<Path> Rows() const {
    const Eigen::Vector3d& at = eye_.position;
    return PathsOf({-at.y(), -eye_.top_mm, eye_.pixel_mm, eye_.height, eye_.plane_mm, Distance()},
                   map_.rows(), [&](double y, double slope) { return map_.MetRow(-y, -slope); });
  }

 private:
  double Distance() const { return eye_.position.z() - eye_.plane_mm; }
  std::vector<Path> PathsOf(const EyeAxis& axis, int count, const auto& seen) const {
    const double z = map_.position_mm(), z_emitters = z - map_.d0_mm();
    const double half_width = count * pitch_mm_ / 2;
    const auto line_of = [&](double at) {
      return Line{seen(axis.OnPlane(at, z), (axis.eye_mm - at) / axis.distance_mm),
                  std::abs(axis.OnPlane(at, z)) >= half_width ||
                      std::abs(axis.OnPlane(at, z_emitters)) >= half_width};
    };
    return AxisPaths(axis, Breaks(axis, {z, z_emitters}, count, pitch_mm_), barrier_, through_,
                     line_of);
  }

  const RayMap map_;
  const Barrier barrier_;
  const Eye& eye_;
  double pitch_mm_;
  Through through_;
};

LayerPaths PathsOfLayer(const Display& display, int layer, const Eye& eye, Through through) {
  const LayerAxes axes(display, layer, eye, through);
  LayerPaths paths{axes.Columns(), axes.Rows(), {}};
  for (int y = 0; y <= eye.height; ++y) {
    const auto first = std::lower_bound(paths.rows.begin(), paths.rows.end(), y,
                                        [](const Path& p, int pixel) { return p.pixel < pixel; });
    paths.first_row.push_back(static_cast<std::size_t>(first - paths.rows.begin()));
  }
  return paths;
}

// The light of emitters on their paths: gain * (black + their content).
struct PanelLight {
  std::vector<const EmitterImage*> slots;  // k x k, by the paths' slots
  int first_row = 0;                       // of theirs
  double gain = 1, black = 0;
};

// Adds what one row path of a layer contributes to the pixels of a picture row.
void AddRow(const PanelLight& light, int k, const std::vector<Path>& columns, const Path& row,
            Seen* sums) {
  std::vector<const Rgb*> colors(static_cast<std::size_t>(k));
  std::vector<const float*> coverages(colors.size());
  if (row.emitter >= 0) {
    for (std::size_t s = 0; s < colors.size(); ++s) {
      const EmitterImage& image = *light.slots[static_cast<std::size_t>(k * row.slot) + s];
      colors[s] = image.color.row(row.emitter - light.first_row);
      coverages[s] = image.coverage.row(row.emitter - light.first_row);
    }
  }
  const double gain = light.gain * row.weight;
  for (const Path& column : columns) {
    Seen& sum = sums[column.pixel];
    const double weight = gain * column.weight;
    sum.all += weight;
    if (row.emitter < 0 || column.emitter < 0) continue;
    const std::size_t slot = static_cast<std::size_t>(column.slot);
    const Rgb& color = colors[slot][column.emitter];
    sum.r += weight * static_cast<double>(color.r);
    sum.g += weight * static_cast<double>(color.g);
    sum.b += weight * static_cast<double>(color.b);
    sum.known += weight * static_cast<double>(coverages[slot][column.emitter]);
  }
  if (light.black == 0 || row.emitter < 0) return;
  for (const Path& column : columns) {
    if (column.emitter < 0) continue;
    Seen& sum = sums[column.pixel];
    const double black = gain * column.weight * light.black;
    sum.r += black;
    sum.g += black;
    sum.b += black;
  }
}

// Of a share r of the slot before in what both panels show, E and T with
//   E'_t = (1 - r) E_t + r E_{t-1},  T'_t = (1 - r) T_t + r T_{t-1},
// the sum of T'_t E'_t over all slots is that of
//   T_t ((1 - 2 r (1 - r)) E_t + r (1 - r) (E_{t-1} + E_{t+1})):
// through a slot's openings some light of the slots before and after is seen. `light` is without.
std::vector<PanelLight> WithSlotCrosstalk(const PanelLight& light, int k, double r) {
  if (r == 0 || k == 1) return {light};
  const double cross = r * (1 - r);
  PanelLight own = light, before = light, after = light;
  own.gain *= 1 - 2 * cross;
  before.gain *= cross;
  after.gain *= cross;
  const std::vector<int> order = SlotOrder(k);
  for (std::size_t t = 0; t < order.size(); ++t) {
    const auto slot = static_cast<std::size_t>(order[t]);
    const auto next = static_cast<std::size_t>(order[(t + 1) % order.size()]);
    after.slots[slot] = light.slots[next];
    before.slots[next] = light.slots[slot];
  }
  return {own, before, after};
}

// A barrier's layer or a bare panel. With a black level b of the emitters and a leak c of the
// modulator (1/contrast), and E the emitters' content on a line of sight, a slot shows
//   (c + (1 - c) T) (b + (1 - b) E),   T = 1 where the slot is open, 0 where it is closed.
class ThroughOpenings final : public LayerSeen {
 public:
  ThroughOpenings(const EmitterStrip& strip, const Display& display, int layer, const Eye& eye) {
    const auto l = static_cast<std::size_t>(layer);
    const Barrier barrier = OpeningsOf(display.layers[l]);
    const int k = barrier.slots;
    // 1 / (slots per layer * (a/P)^2): n cancels the superposition's 1/n.
    const double open = static_cast<double>(k) * barrier.aperture_px / barrier.period_px;
    const double b = 1 / display.contrast, c = 1 / barrier.contrast;
    PanelLight light{{}, strip.first_row[l], (1 - c) * (1 - b) / (open * open), b / (1 - b)};
    for (const EmitterImage& slot : strip.images->slots[l]) light.slots.push_back(&slot);
    parts_.push_back({PathsOfLayer(display, layer, eye, Through::kOpenings), k,
                      WithSlotCrosstalk(light, k, display.slot_crosstalk)});
    if (c == 0) return;
    light.slots = {&strip.leaks[l]};
    light.gain = c * (1 - b) * k * k / (open * open);
    parts_.push_back({PathsOfLayer(display, layer, eye, Through::kFace), 1, {light}});
  }
  void Add(PictureRows& band) const override {
    for (const Part& part : parts_) {
      for (int y = band.first_row; y < band.end_row; ++y) {
        const auto row = static_cast<std::size_t>(y);
        const std::size_t end = part.paths.first_row[row + 1];
        for (std::size_t r = part.paths.first_row[row]; r < end; ++r) {
          for (const PanelLight& light : part.lights) {
            AddRow(light, part.k, part.paths.columns, part.paths.rows[r],
                   band.sums.row(y - band.first_row));
          }
        }
      }
    }
  }

 private:
  struct Part {
    LayerPaths paths;
    int k = 1;
    std::vector<PanelLight> lights;
  };
  std::vector<Part> parts_;
};

}  // namespace

std::unique_ptr<LayerSeen> SeeThroughOpenings(const EmitterStrip& strip, const Display& display,
                                              int layer, const Eye& eye) {
  return std::make_unique<ThroughOpenings>(strip, display, layer, eye);
}

std::vector<RowRange> RowsThroughOpenings(const Display& display, int layer, const Eye& eye) {
  std::vector<RowRange> bands(
      static_cast<std::size_t>((eye.height + kPictureBandRows - 1) / kPictureBandRows));
  for (const Path& path : LayerAxes(display, layer, eye, Through::kFace).Rows()) {
    if (path.emitter < 0) continue;
    RowRange& band = bands[static_cast<std::size_t>(path.pixel / kPictureBandRows)];
    band = band.With({path.emitter, path.emitter + 1});
  }
  return bands;
}

}  // namespace lamella
