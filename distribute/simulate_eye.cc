#include "distribute/simulate_eye.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <memory>
#include <numbers>
#include <optional>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "distribute/analyze.h"
#include "distribute/encode_barrier.h"
#include "distribute/seen_elements.h"
#include "lightfield/error.h"
#include "lightfield/layer_map.h"
#include "lightfield/parallel.h"
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

struct LayerPaths {
  std::vector<Path> columns, rows;
  std::vector<std::size_t> first_row;  // of each pixel row in `rows`, and the end
};

LayerPaths PathsOfLayer(const Display& display, int layer, const Eye& eye, Through through) {
  const RayMap map(display, layer);
  const Barrier barrier = OpeningsOf(display.layers[static_cast<std::size_t>(layer)]);
  const double z = map.position_mm(), z_emitters = z - map.d0_mm();
  const double plane = eye.plane_mm, d = eye.position.z() - plane;
  const double pitch = display.emitter_pitch_mm(display.layers[static_cast<std::size_t>(layer)]);
  const auto paths_of = [&](const EyeAxis& axis, int count, const auto& seen) {
    const double half_width = count * pitch / 2;
    const auto line_of = [&](double at) {
      return Line{seen(axis.OnPlane(at, z), (axis.eye_mm - at) / d),
                  std::abs(axis.OnPlane(at, z)) >= half_width ||
                      std::abs(axis.OnPlane(at, z_emitters)) >= half_width};
    };
    return AxisPaths(axis, Breaks(axis, {z, z_emitters}, count, pitch), barrier, through, line_of);
  };
  LayerPaths paths;
  paths.columns =
      paths_of({eye.position.x(), eye.left_mm, eye.pixel_mm, eye.width, plane, d}, map.columns(),
               [&](double at, double slope) { return map.MetColumn(at, slope); });
  paths.rows =
      paths_of({-eye.position.y(), -eye.top_mm, eye.pixel_mm, eye.height, plane, d}, map.rows(),
               [&](double at, double slope) { return map.MetRow(-at, -slope); });
  for (int y = 0; y <= eye.height; ++y) {
    const auto first = std::lower_bound(paths.rows.begin(), paths.rows.end(), y,
                                        [](const Path& p, int pixel) { return p.pixel < pixel; });
    paths.first_row.push_back(static_cast<std::size_t>(first - paths.rows.begin()));
  }
  return paths;
}

struct Seen {
  double r = 0, g = 0, b = 0;
  double known = 0, all = 0;
};

// Some rows of the picture.
struct PictureRows {
  int first_row = 0, end_row = 0;
  Image<Seen> sums;  // first_row is row 0
};

// The light of emitters on their paths: gain * (black + their content).
struct PanelLight {
  std::vector<const EmitterImage*> slots;  // k x k, by the paths' slots
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
      colors[s] = image.color.row(row.emitter);
      coverages[s] = image.coverage.row(row.emitter);
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

// A layer as the eye sees it; what it shows of a band can be added by many threads.
class LayerSeen {
 public:
  virtual ~LayerSeen() = default;
  virtual void Add(PictureRows& band) const = 0;
};

// The mean of a layer's emitters over its slots.
EmitterImage SlotMean(const std::vector<EmitterImage>& slots) {
  const int width = slots[0].color.width(), height = slots[0].color.height();
  EmitterImage mean{Image<Rgb>(width, height), Image<float>(width, height)};
  const float share = 1 / static_cast<float>(slots.size());
  ParallelFor(0, height, 16, [&](std::int64_t first, std::int64_t last) {
    for (int y = static_cast<int>(first); y < static_cast<int>(last); ++y) {
      for (const EmitterImage& slot : slots) {
        for (int x = 0; x < width; ++x) {
          mean.color(x, y) += share * slot.color(x, y);
          mean.coverage(x, y) += share * slot.coverage(x, y);
        }
      }
    }
  });
  return mean;
}

// By layer, what closed modulators let through; empty where they let nothing through.
std::vector<EmitterImage> Leaks(const LayerImages& layers, const Display& display) {
  std::vector<EmitterImage> leaks(display.layers.size());
  for (std::size_t l = 0; l < leaks.size(); ++l) {
    const auto* barrier = std::get_if<Barrier>(&display.layers[l].optics);
    if (barrier != nullptr && std::isfinite(barrier->contrast)) {
      leaks[l] = SlotMean(layers.slots[l]);
    }
  }
  return leaks;
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
class BarrierSeen final : public LayerSeen {
 public:
  // `leak`: what Leaks has of the layer.
  BarrierSeen(const std::vector<EmitterImage>& slots, const EmitterImage& leak,
              const Display& display, int layer, const Eye& eye) {
    const Barrier barrier = OpeningsOf(display.layers[static_cast<std::size_t>(layer)]);
    const int k = barrier.slots;
    // 1 / (slots per layer * (a/P)^2): n cancels the superposition's 1/n.
    const double open = static_cast<double>(k) * barrier.aperture_px / barrier.period_px;
    const double b = 1 / display.contrast, c = 1 / barrier.contrast;
    PanelLight light{{}, (1 - c) * (1 - b) / (open * open), b / (1 - b)};
    for (const EmitterImage& slot : slots) light.slots.push_back(&slot);
    parts_.push_back({PathsOfLayer(display, layer, eye, Through::kOpenings), k,
                      WithSlotCrosstalk(light, k, display.slot_crosstalk)});
    if (c == 0) return;
    light.slots = {&leak};
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

LayerView ViewOf(const Display& display, int index, const Eye& eye) {
  const Layer& layer = display.layers[static_cast<std::size_t>(index)];
  const double pitch = display.emitter_pitch_mm(layer), d = eye.position.z() - eye.plane_mm;
  const double share = (layer.position_mm - eye.plane_mm) / d;
  const double to_px = 1 / ((1 - share) * eye.pixel_mm);
  const Eigen::Vector3d& e = eye.position;
  LayerView view;
  view.scale = pitch * to_px;
  view.offset_x = -(display.emitter_columns() / 2.0 * pitch + e.x() * share) * to_px -
                  eye.left_mm / eye.pixel_mm;
  view.offset_y =
      eye.top_mm / eye.pixel_mm - (display.emitter_rows() / 2.0 * pitch - e.y() * share) * to_px;
  view.slope_x = {(e.x() - eye.left_mm) / d, -eye.pixel_mm / d, 0};
  view.slope_y = {(e.y() - eye.top_mm) / d, 0, eye.pixel_mm / d};
  return view;
}

// Lenses: every element's polygon is cut to the pixels, and those to the emitters seen there.
class ElementsSeen final : public LayerSeen {
 public:
  ElementsSeen(const EmitterImage& emitters, const Display& display, int layer, const Eye& eye)
      : emitters_(emitters),
        map_(display, layer),
        elements_(SeenElements(display, layer, ViewOf(display, layer, eye))) {
    const Layer& of = display.layers[static_cast<std::size_t>(layer)];
    black_ = 1 / display.contrast;
    subpixels_ = std::holds_alternative<Lenticular>(of.optics);
    mirrored_ = of.mirror_x;
    rays_ = subpixels_ ? 0 : std::get<LensletArray>(of.optics).rays;
  }

  void Add(PictureRows& band) const override {
    for (const SeenElement& element : elements_) {
      double top = element.cell[0].y, bottom = top;
      for (int i = 1; i < element.cell.size; ++i) {
        top = std::min(top, element.cell[i].y);
        bottom = std::max(bottom, element.cell[i].y);
      }
      const double first = std::max<double>(std::floor(top), band.first_row);
      const double end = std::min<double>(std::ceil(bottom), band.end_row);
      for (int y = static_cast<int>(first); y < end; ++y) AddRowOf(element, y, band);
    }
  }

 private:
  void AddRowOf(const SeenElement& element, int y, PictureRows& band) const {
    const ConvexPolygon part = CutBetween(element.cell, {0, 0, 1}, y, y + 1);
    if (part.size < 3) return;
    double left = part[0].x, right = left;
    for (int i = 1; i < part.size; ++i) {
      left = std::min(left, part[i].x);
      right = std::max(right, part[i].x);
    }
    const double first = std::max(std::floor(left), 0.0);
    const double end = std::min<double>(std::ceil(right), band.sums.width());
    for (int x = static_cast<int>(first); x < end; ++x) {
      AddPiece(element, CutBetween(part, {0, 1, 0}, x, x + 1), band.sums(x, y - band.first_row));
    }
  }

  // Calls add(part, index) for the parts of a piece that lie between whole values of the form.
  template <class AddPart>
  static void Split(const ConvexPolygon& piece, const AffineForm& form, const AddPart& add) {
    if (piece.size < 3) return;
    double least = form.At(piece[0]), most = least;
    for (int i = 1; i < piece.size; ++i) {
      least = std::min(least, form.At(piece[i]));
      most = std::max(most, form.At(piece[i]));
    }
    const double first = std::floor(least), last = std::ceil(most) - 1;
    if (last <= first) return add(piece, first);
    for (double at = first; at <= last; ++at) add(CutBetween(piece, form, at, at + 1), at);
  }

  void AddPiece(const SeenElement& element, const ConvexPolygon& piece, Seen& sum) const {
    Split(piece, element.column, [&](const ConvexPolygon& part, double column) {
      Split(part, element.row, [&](const ConvexPolygon& of_emitter, double row) {
        AddEmitter(element, column, row, of_emitter.Area(), sum);
      });
    });
  }

  void AddEmitter(const SeenElement& element, double column, double row, double area,
                  Seen& sum) const {
    const double per_pixel = subpixels_ ? 3 : 1;
    if (!(column >= 0 && column < per_pixel * emitters_.color.width() && row >= 0 &&
          row < emitters_.color.height())) {
      return;
    }
    const int x = static_cast<int>(column / per_pixel), y = static_cast<int>(row);
    const bool guard = !subpixels_ && !IsLit(element, x, y);
    if (guard && black_ == 0) return;
    const Rgb color = guard ? Rgb{} : emitters_.color(x, y);
    const int third = static_cast<int>(column) % 3;
    const int channel = subpixels_ ? (mirrored_ ? 2 - third : third) : -1;
    const auto light = [&](float content) {
      return area * per_pixel * (black_ + (1 - black_) * static_cast<double>(content));
    };
    if (channel < 0 || channel == 0) sum.r += light(color.r);
    if (channel < 0 || channel == 1) sum.g += light(color.g);
    if (channel < 0 || channel == 2) sum.b += light(color.b);
    if (guard) return;
    sum.known += area * static_cast<double>(emitters_.coverage(x, y));
    sum.all += area;
  }

  bool IsLit(const SeenElement& element, int x, int y) const {
    const int column = x - element.window_column, row = y - element.window_row;
    if (column >= 0 && column < rays_ && row >= 0 && row < rays_) return true;
    return map_.BeamOf(0, 0, x, y).has_value();
  }

  const EmitterImage& emitters_;
  const LayerMap map_;
  const std::vector<SeenElement> elements_;
  double black_ = 0;  // of white
  bool subpixels_ = false, mirrored_ = false;
  int rays_ = 0;
};

std::unique_ptr<LayerSeen> See(const std::vector<EmitterImage>& slots, const EmitterImage& leak,
                               const Display& display, int layer, const Eye& eye) {
  const Optics& optics = display.layers[static_cast<std::size_t>(layer)].optics;
  if (std::holds_alternative<Barrier>(optics) || std::holds_alternative<BarePanel>(optics)) {
    return std::make_unique<BarrierSeen>(slots, leak, display, layer, eye);
  }
  return std::make_unique<ElementsSeen>(slots[0], display, layer, eye);
}

void CheckInput(const LayerImages& layers, const Display& display, const Eye& eye) {
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
    if (!(eye.position.z() > std::max(eye.plane_mm, display.layers[l].position_mm)) ||
        !eye.position.allFinite()) {
      throw UsageError("eye",
                       fmt::format("at {:g} mm is not in front of layer {} at {:g} mm",
                                   eye.position.z(), l, display.layers[l].position_mm),
                       "give a larger viewing distance");
    }
  }
}

EyePicture Simulate(const LayerImages& layers, const std::vector<EmitterImage>& leaks,
                    const Display& display, const Eye& eye) {
  std::vector<std::unique_ptr<LayerSeen>> seen(display.layers.size());
  ParallelForEach(0, static_cast<std::int64_t>(seen.size()), [&](std::int64_t layer) {
    const auto l = static_cast<std::size_t>(layer);
    seen[l] = See(layers.slots[l], leaks[l], display, static_cast<int>(layer), eye);
  });
  EyePicture picture{Image<Rgb>(eye.width, eye.height), Image<float>(eye.width, eye.height)};
  constexpr int kBandRows = 16;
  ParallelForEach(0, (eye.height + kBandRows - 1) / kBandRows, [&](std::int64_t b) {
    const int first = static_cast<int>(b) * kBandRows;
    const int end = std::min(first + kBandRows, eye.height);
    PictureRows band{first, end, Image<Seen>(eye.width, end - first)};
    for (const std::unique_ptr<LayerSeen>& layer : seen) layer->Add(band);
    for (int y = first; y < end; ++y) {
      for (int x = 0; x < eye.width; ++x) {
        const Seen& sum = band.sums(x, y - first);
        picture.color(x, y) = {static_cast<float>(sum.r), static_cast<float>(sum.g),
                               static_cast<float>(sum.b)};
        picture.coverage(x, y) =
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

EyePicture SimulateEye(const LayerImages& layers, const Display& display, const Eye& eye) {
  CheckInput(layers, display, eye);
  return Simulate(layers, Leaks(layers, display), display, eye);
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

EyePicture SimulateEye(const LayerImages& layers, const Display& display, const Eye& eye,
                       const Pupil& pupil) {
  CheckInput(layers, display, eye);
  const std::vector<EmitterImage> leaks = Leaks(layers, display);
  EyePicture mean{Image<Rgb>(eye.width, eye.height), Image<float>(eye.width, eye.height)};
  const float weight = 1.0F / static_cast<float>(pupil.samples);
  for (const Eye& sample : PupilSamples(eye, pupil)) {
    const EyePicture picture = Simulate(layers, leaks, display, sample);
    for (std::size_t i = 0; i < mean.color.size(); ++i) {
      mean.color.data()[i] += weight * picture.color.data()[i];
      mean.coverage.data()[i] += weight * picture.coverage.data()[i];
    }
  }
  return mean;
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
