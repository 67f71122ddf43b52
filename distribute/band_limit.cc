#include "distribute/band_limit.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <variant>

#include "distribute/accumulate.h"
#include "distribute/analyze.h"
#include "distribute/blur_planes.h"
#include "distribute/box_blur.h"
#include "lightfield/parallel.h"

namespace lamella {
namespace {

// Between planes the blur is interpolated: with this, off by less than 1 % of the contrast of waves
// below the beam's cut-off, and by 5 % beyond.
constexpr double kWideningOfLimit = 0.3;
constexpr double kFarthestOfLimit = -16;  // in viewing distances; behind it is infinity
constexpr int kRowsOfStrip = 128;
// Of a regular hexagon's width between its sides, sqrt(5/6): its variance on any axis is 5/72 of
// that width's square, a box's 1/12.
constexpr double kBoxOfHexagon = 0.9128709291752769;
constexpr float kLeastWeight = 1e-7F;  // of light, to be divided by
constexpr float kNowhere = -2;         // the place of what is not known

// The beams' widths in the middle of a layer.
Beam ProductBeam(const Display& display, const Layer& layer) {
  Beam beam = MiddleBeams(display, layer);
  if (const auto* lenslets = std::get_if<LensletArray>(&layer.optics)) {
    if (lenslets->lattice == LensletArray::Lattice::kHexagonal) {
      beam.x.aperture_mm *= kBoxOfHexagon;
      beam.y.aperture_mm *= kBoxOfHexagon;
    }
  }
  return beam;
}

// The layers that show any depth between the planes beside a plane.
void AddParts(int plane, BandLimit& limit) {
  const auto at = static_cast<std::size_t>(plane);
  const double behind = limit.planes_mm[at - (at > 0 ? 1 : 0)];
  const double before = at + 1 < limit.planes_mm.size() ? limit.planes_mm[at + 1]
                                                        : std::numeric_limits<double>::infinity();
  const auto shows = [&](int layer, double z) {
    return limit.weights.Weight(layer, static_cast<float>(z)) > 0;
  };
  int first = 0, last = limit.weights.num_layers() - 1;
  while (!shows(first, behind)) ++first;
  while (!shows(last, before)) --last;
  for (int layer = first; layer <= last; ++layer) limit.parts.push_back({plane, layer});
}

// The section of a beam on one axis, as two filters of the eye's pixels.
struct SectionFilter {
  BoxFilter opening, emitter;
  // Pixels that BlurRow and BlurColumns want on both sides: for the second box, and in all.
  int inner() const { return emitter.core + 1; }
  int outer() const { return inner() + opening.core + 1; }
  int reach() const { return opening.reach() + emitter.reach(); }
};

// Lengths at z as they are seen on the picture's plane.
SectionFilter FilterOf(const AxisBeam& beam, double layer_mm, double z, const Eye& eye) {
  const double pixels = (eye.position.z() - eye.plane_mm) / eye.pixel_mm;
  if (std::isinf(z)) {  // the limit of what follows
    return {BoxOfWidth(pixels * beam.aperture_mm * std::abs(beam.kappa_per_mm())),
            BoxOfWidth(pixels * beam.emitter_width_mm / std::abs(beam.d0_mm))};
  }
  const double pixels_per_mm = pixels / (eye.position.z() - z), offset = z - layer_mm;
  return {BoxOfWidth(pixels_per_mm * beam.OpeningBlurMm(offset)),
          BoxOfWidth(pixels_per_mm * beam.EmitterBlurMm(offset))};
}

// Columns of a row, [first, end).
struct ColumnRun {
  int first = std::numeric_limits<int>::max(), end = 0;
  bool empty() const { return first >= end; }
  void Add(const ColumnRun& run) {
    first = std::min(first, run.first);
    end = std::max(end, run.end);
  }
};

// A scene, where its pixels lie among the planes (3.25: between planes 3 and 4), and in which
// columns of a row there is light of a part.
struct SceneByPlanes {
  const SeenScene& scene;
  const BandLimit& limit;
  Image<float> places;
  Image<ColumnRun> runs;  // a column for every part

  // What a pixel gives to a part.
  Light LightOf(const BlurPart& part, int x, int y) const {
    const float share = 1 - std::abs(places(x, y) - static_cast<float>(part.plane));
    if (!(share > 0)) return {};
    const float weight = share * limit.weights.Weight(part.layer, scene.z(x, y));
    const Rgb light = weight * scene.light(x, y);
    return {light.r, light.g, light.b, weight * scene.coverage(x, y)};
  }
};

// Places are even in 1 / the distance from the eye: widths as seen are piecewise linear in it.
class PlanesOfEye {
 public:
  PlanesOfEye(const BandLimit& limit, const Eye& eye) : planes_(limit.planes_mm) {
    for (const double z : planes_) nearness_.push_back(1 / (eye.position.z() - z));
    distance_mm_ = eye.position.z();
  }
  float PlaceOf(float depth) const {
    const double z = static_cast<double>(depth);
    if (!(z > planes_.front())) return 0;
    if (z >= planes_.back()) return static_cast<float>(planes_.size() - 1);
    const auto next = std::upper_bound(planes_.begin(), planes_.end(), z);
    const auto i = static_cast<std::size_t>(next - planes_.begin());
    const double share =
        (1 / (distance_mm_ - z) - nearness_[i - 1]) / (nearness_[i] - nearness_[i - 1]);
    return static_cast<float>(static_cast<double>(i - 1) + share);
  }

 private:
  const std::vector<double>& planes_;
  std::vector<double> nearness_;
  double distance_mm_ = 0;
};

bool IsKnown(const SeenScene& scene, int x, int y) {
  const Rgb light = scene.light(x, y);
  return scene.coverage(x, y) > 0 && std::isfinite(light.r + light.g + light.b);
}

SceneByPlanes SortByPlanes(const SeenScene& scene, const BandLimit& limit, const Eye& eye) {
  const int width = scene.z.width(), height = scene.z.height();
  const auto num_parts = static_cast<int>(limit.parts.size());
  SceneByPlanes sorted{scene, limit, Image<float>(width, height, kNowhere),
                       Image<ColumnRun>(num_parts, height)};
  const PlanesOfEye planes(limit, eye);
  ParallelFor(0, height, kRowsOfStrip, [&](std::int64_t first_row, std::int64_t end_row) {
    for (int y = static_cast<int>(first_row); y < end_row; ++y) {
      ColumnRun* runs = sorted.runs.row(y);
      for (int x = 0; x < width; ++x) {
        if (!IsKnown(scene, x, y)) continue;
        const float place = sorted.places(x, y) = planes.PlaceOf(scene.z(x, y));
        const auto part =
            std::lower_bound(limit.parts.begin(), limit.parts.end(), static_cast<int>(place),
                             [](const BlurPart& a, int plane) { return a.plane < plane; });
        for (auto i = part - limit.parts.begin(); i < num_parts; ++i) {
          const BlurPart& at = limit.parts[static_cast<std::size_t>(i)];
          if (at.plane > static_cast<int>(place) + 1) break;
          if (sorted.LightOf(at, x, y).coverage > 0) runs[i].Add({x, x + 1});
        }
      }
    }
  });
  return sorted;
}

// Rows of the band-limited picture: the sum of the parts.
class StripOfLimit {
 public:
  StripOfLimit(const SceneByPlanes& sorted, int first_row, int end_row)
      : sorted_(sorted),
        first_row_(first_row),
        num_rows_(end_row - first_row),
        sums_(sorted.places.width(), num_rows_) {}

  void Add(std::size_t part, const SectionFilter& along_x, const SectionFilter& along_y);
  Rgb ColorAt(int x, int y) const {
    const Light& sum = sums_(x, y - first_row_);
    if (!(sum.coverage > kLeastWeight)) return {};
    return 1 / sum.coverage * Rgb{sum.r, sum.g, sum.b};
  }

 private:
  // A row of a part, blurred along x, from a column on.
  void BlurAlongX(std::size_t part, int y, const SectionFilter& filter, int first_column, int count,
                  Light* out);

  const SceneByPlanes& sorted_;
  int first_row_ = 0, num_rows_ = 0;
  Image<Light> sums_;
  std::vector<Light> row_, half_blurred_;
};

void StripOfLimit::BlurAlongX(std::size_t part, int y, const SectionFilter& filter,
                              int first_column, int count, Light* out) {
  const int half_blurred = count + 2 * filter.inner(), all = count + 2 * filter.outer();
  row_.assign(static_cast<std::size_t>(all), {});
  half_blurred_.resize(static_cast<std::size_t>(half_blurred));
  const int origin = first_column - filter.outer();
  const ColumnRun& run = sorted_.runs(static_cast<int>(part), y);
  for (int x = run.first; x < run.end; ++x) {
    row_[static_cast<std::size_t>(x - origin)] = sorted_.LightOf(sorted_.limit.parts[part], x, y);
  }
  BlurRow(filter.opening, row_.data() + filter.opening.core + 1, half_blurred,
          half_blurred_.data());
  BlurRow(filter.emitter, half_blurred_.data() + filter.inner(), count, out);
}

void StripOfLimit::Add(std::size_t part, const SectionFilter& along_x,
                       const SectionFilter& along_y) {
  const int column = static_cast<int>(part);
  const int from = std::max(0, first_row_ - along_y.reach());
  const int to = std::min(sorted_.runs.height(), first_row_ + num_rows_ + along_y.reach());
  ColumnRun lit;
  for (int y = from; y < to; ++y) lit.Add(sorted_.runs(column, y));
  if (lit.empty()) return;
  lit = {std::max(0, lit.first - along_x.reach()),
         std::min(sums_.width(), lit.end + along_x.reach())};
  const int width = lit.end - lit.first;
  Image<Light> rows(width, num_rows_ + 2 * along_y.outer());
  for (int y = from; y < to; ++y) {
    if (sorted_.runs(column, y).empty()) continue;
    BlurAlongX(part, y, along_x, lit.first, width, rows.row(y - first_row_ + along_y.outer()));
  }
  Image<Light> half_blurred(width, num_rows_ + 2 * along_y.inner());
  BlurColumns(along_y.opening, rows.span(), half_blurred.span());
  BlurColumns(along_y.emitter, half_blurred.span(), rows.span().Sub({0, 0, width, num_rows_}));
  for (int y = 0; y < num_rows_; ++y) {
    for (int x = 0; x < width; ++x) {
      Light& sum = sums_(lit.first + x, y);
      const Light& light = rows(x, y);
      sum = {sum.r + light.r, sum.g + light.g, sum.b + light.b, sum.coverage + light.coverage};
    }
  }
}

}  // namespace

BandLimit BandLimitOf(const Display& display) {
  BandLimit limit{WeightsOf(display), {}, {}, {}, {}};
  std::vector<BeamOfLayer> along_x;
  for (const Layer& layer : display.layers) {
    limit.layers_mm.push_back(layer.position_mm);
    limit.beams.push_back(ProductBeam(display, layer));
    along_x.push_back({limit.beams.back().x, layer.position_mm});
  }
  limit.planes_mm = BlurPlanes(display, along_x, kWideningOfLimit,
                               kFarthestOfLimit * display.viewing_distance_mm);
  limit.planes_mm.insert(limit.planes_mm.begin(), -std::numeric_limits<double>::infinity());
  for (int plane = 0; plane < std::ssize(limit.planes_mm); ++plane) AddParts(plane, limit);
  return limit;
}

Image<Rgb> BandLimited(const SeenScene& scene, const BandLimit& limit, const Eye& eye) {
  const SceneByPlanes sorted = SortByPlanes(scene, limit, eye);
  std::vector<SectionFilter> along_x, along_y;
  for (const BlurPart& part : limit.parts) {
    const auto layer = static_cast<std::size_t>(part.layer);
    const double layer_mm = limit.layers_mm[layer];
    const double z = limit.planes_mm[static_cast<std::size_t>(part.plane)];
    along_x.push_back(FilterOf(limit.beams[layer].x, layer_mm, z, eye));
    along_y.push_back(FilterOf(limit.beams[layer].y, layer_mm, z, eye));
  }
  Image<Rgb> limited(eye.width, eye.height);
  const int num_strips = (eye.height + kRowsOfStrip - 1) / kRowsOfStrip;
  ParallelForEach(0, num_strips, [&](std::int64_t strip) {
    const int first = static_cast<int>(strip) * kRowsOfStrip;
    const int end = std::min(first + kRowsOfStrip, eye.height);
    StripOfLimit rows(sorted, first, end);
    for (std::size_t part = 0; part < limit.parts.size(); ++part) {
      rows.Add(part, along_x[part], along_y[part]);
    }
    for (int y = first; y < end; ++y) {
      for (int x = 0; x < eye.width; ++x) {
        if (scene.coverage(x, y) > 0) limited(x, y) = rows.ColorAt(x, y);
      }
    }
  });
  return limited;
}

}  // namespace lamella
