#include "datasets_synthetic/prototype.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "datasets_synthetic/pixel_points.h"
#include "lightfield/error.h"
#include "lightfield/panel_rays.h"
#include "lightfield/parallel.h"

namespace lamella {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

struct Sum {
  double r = 0, g = 0, b = 0;
  void Add(double weight, const Sum& light) {
    r += weight * light.r;
    g += weight * light.g;
    b += weight * light.b;
  }
  void Add(double weight, const Rgb& light) {
    r += weight * static_cast<double>(light.r);
    g += weight * static_cast<double>(light.g);
    b += weight * static_cast<double>(light.b);
  }
};

// The index of the pixel that holds a coordinate; nothing beside the panel (and for NaN).
std::optional<int> PixelOf(double coordinate, int size) {
  if (!(coordinate >= 0 && coordinate < size)) return std::nullopt;
  return static_cast<int>(coordinate);
}

// A layer ready to be traced.
struct TracedLayer {
  LayerSights sights;
  const LayerCalibration* calibration;
  double falloff;                        // exponent of both panels
  std::vector<const ShownLayer*> shown;  // one per show; null where the layer is dark in it

  // What the emitter sends from a place within its pixel.
  Rgb Emitted(const Image<Rgb>& image, int x, int y, double u) const {
    const Rgb& light = image(x, y);
    if (!calibration->emitter.rgb_stripes) return light;
    const int channel = std::clamp(static_cast<int>(3 * (u - x)), 0, 2);
    const float level = channel == 0 ? light.r : channel == 1 ? light.g : light.b;
    const Eigen::Vector3f stripe =
        3 * level * calibration->emitter.photometry.primaries.col(channel).cast<float>();
    return {stripe.x(), stripe.y(), stripe.z()};
  }

  // Adds to the sum of a show.
  void AddLight(const SightHit& hit, std::size_t show, Sum& sum) const {
    if (!shown[show]) return;
    const ShownLayer& images = *shown[show];
    const PanelCalibration& emitter = calibration->emitter;
    const std::optional<int> x = PixelOf(hit.emitter.x(), emitter.width_px),
                             y = PixelOf(hit.emitter.y(), emitter.height_px);
    if (!x || !y) return;
    const std::size_t slots = images.emitter.size();
    double scale = calibration->gain / static_cast<double>(slots);
    if (falloff > 0) scale *= std::pow(hit.cosine, falloff);
    if (!calibration->modulator) {
      for (const auto& image : images.emitter) {
        sum.Add(scale, Emitted(*image, *x, *y, hit.emitter.x()));
      }
      return;
    }
    const std::optional<int> u = PixelOf(hit.modulator.x(), calibration->modulator->width_px),
                             v = PixelOf(hit.modulator.y(), calibration->modulator->height_px);
    if (!u || !v) return;
    for (std::size_t slot = 0; slot < slots; ++slot) {
      const float transmittance = (*images.modulator[slot])(*u, *v);
      if (transmittance == 0) continue;
      sum.Add(scale * static_cast<double>(transmittance),
              Emitted(*images.emitter[slot], *x, *y, hit.emitter.x()));
    }
  }
};

// Light of the sheet along a line of sight.
void AddLight(const PrintedSheet& sheet, const Vector3d& origin, const Vector3d& direction,
              Sum& sum) {
  const Rigid sheet_from_display = Inverse(sheet.display_from_sheet);
  const Vector3d from = sheet_from_display * origin,
                 along = sheet_from_display.rotation * direction;
  if (!(from.z() > 0 && along.z() < 0)) return;  // its back is not seen
  const Vector3d at = from - from.z() / along.z() * along;
  const Image<Rgb>& light = *sheet.light;
  const std::optional<int> x =
      PixelOf(light.width() / 2.0 + at.x() / sheet.pixel_mm, light.width());
  const std::optional<int> y =
      PixelOf(light.height() / 2.0 - at.y() / sheet.pixel_mm, light.height());
  if (x && y) sum.Add(1, light(*x, *y));
}

// The hits of lines of sight through a rectangle of a picture whose corners' are known and that
// turn evenly between them: x and y run from 0 to 1 over the rectangle.
class EvenHits {
 public:
  // Left and right above, left and right below.
  explicit EvenHits(const std::array<SightHit, 4>& corners)
      : corner_(Numbers(corners[0])),
        along_x_(Numbers(corners[1]) - corner_),
        along_y_(Numbers(corners[2]) - corner_),
        along_both_(Numbers(corners[3]) - corner_ - along_x_ - along_y_) {}

  SightHit At(double x, double y) const {
    const Vector5d numbers = corner_ + x * along_x_ + y * (along_y_ + x * along_both_);
    return {numbers.head<2>(), numbers.segment<2>(2), numbers(4)};
  }
  // Those of a part, of which again the corners are asked for.
  std::array<SightHit, 4> CornersOf(double left, double top, double right, double bottom) const {
    return {At(left, top), At(right, top), At(left, bottom), At(right, bottom)};
  }

 private:
  using Vector5d = Eigen::Matrix<double, 5, 1>;
  static Vector5d Numbers(const SightHit& hit) {
    Vector5d numbers;
    numbers << hit.modulator, hit.emitter, hit.cosine;
    return numbers;
  }
  Vector5d corner_, along_x_, along_y_, along_both_;
};

// The panel's pixels that corners enclose, with some room for lines that bend; none beside the
// panel. Nothing where the panel's border is among them, or they are many.
std::optional<Rect> Enclosed(const std::array<SightHit, 4>& corners, Vector2d SightHit::*on,
                             const PanelCalibration& panel) {
  constexpr double kRoomPx = 0.01;
  constexpr int kMost = 32;  // in a row
  Vector2d low = corners[0].*on, high = low;
  for (const SightHit& corner : corners) {
    low = low.cwiseMin(corner.*on);
    high = high.cwiseMax(corner.*on);
  }
  low.array() -= kRoomPx;
  high.array() += kRoomPx;
  const Vector2d size(panel.width_px, panel.height_px);
  if (high.minCoeff() < 0 || (low - size).maxCoeff() >= 0) return Rect{0, 0, 0, 0};
  const bool inside = low.minCoeff() >= 0 && (high - size).maxCoeff() < 0;
  if (!inside || !((high - low).maxCoeff() < kMost)) return std::nullopt;
  const int x = static_cast<int>(low.x()), y = static_cast<int>(low.y());
  return Rect{x, y, static_cast<int>(high.x()) - x + 1, static_cast<int>(high.y()) - y + 1};
}

template <class T>
bool IsOneColour(const Image<T>& image, const Rect& rect) {
  if (rect.width == 0) return true;
  const T& first = image(rect.x, rect.y);
  for (int y = rect.y; y < rect.y + rect.height; ++y) {
    const T* row = image.row(y) + rect.x;
    if (!std::all_of(row, row + rect.width, [&](const T& other) { return other == first; })) {
      return false;
    }
  }
  return true;
}

// In a show in which the layer is lit.
bool SeeOneColour(const TracedLayer& layer, std::size_t show,
                  const std::array<SightHit, 4>& corners) {
  const LayerCalibration& calibration = *layer.calibration;
  if (calibration.emitter.rgb_stripes || layer.falloff > 0) return false;
  const auto emitters = Enclosed(corners, &SightHit::emitter, calibration.emitter);
  if (!emitters) return false;
  const ShownLayer& shown = *layer.shown[show];
  const bool emitted =
      std::all_of(shown.emitter.begin(), shown.emitter.end(),
                  [&](const auto& image) { return IsOneColour(*image, *emitters); });
  if (!emitted || !calibration.modulator) return emitted;
  const auto openings = Enclosed(corners, &SightHit::modulator, *calibration.modulator);
  return openings && std::all_of(shown.modulator.begin(), shown.modulator.end(),
                                 [&](const auto& image) { return IsOneColour(*image, *openings); });
}

bool IsDark(const ShownLayer& shown) {
  return std::all_of(shown.emitter.begin(), shown.emitter.end(), [](const auto& image) {
    return std::all_of(image->data(), image->data() + image->size(),
                       [](const Rgb& light) { return light == Rgb(); });
  });
}

// The layers that show anything: patterns are shown on one at a time.
std::vector<TracedLayer> Traced(const Calibration& calibration, std::span<const Show> shows) {
  std::vector<TracedLayer> layers;
  for (std::size_t l = 0; l < calibration.layers.size(); ++l) {
    const LayerCalibration& layer = calibration.layers[l];
    std::vector<const ShownLayer*> shown;
    for (const Show& show : shows) {
      shown.push_back(IsDark(show.layers[l]) ? nullptr : &show.layers[l]);
    }
    if (std::all_of(shown.begin(), shown.end(), [](const auto* lit) { return !lit; })) continue;
    const double falloff = layer.emitter.photometry.falloff +
                           (layer.modulator ? layer.modulator->photometry.falloff : 0);
    layers.push_back({LayerSights(layer), &layer, falloff, std::move(shown)});
  }
  return layers;
}

template <class T>
bool Fits(const std::shared_ptr<const Image<T>>& image, const PanelCalibration& panel) {
  return image && image->width() == panel.width_px && image->height() == panel.height_px;
}

void CheckShown(const std::vector<LayerCalibration>& layers, const Show& show) {
  if (layers.size() != show.layers.size()) {
    throw InputError(
        "",
        fmt::format("{} layers are shown of a display of {}", show.layers.size(), layers.size()),
        "show every layer");
  }
  for (std::size_t l = 0; l < layers.size(); ++l) {
    const ShownLayer& shown = show.layers[l];
    const std::size_t modulators = layers[l].modulator ? shown.emitter.size() : 0;
    if (shown.emitter.empty() || shown.modulator.size() != modulators) {
      throw InputError(
          fmt::format("layer {}", l),
          fmt::format("shows {} emitter and {} modulator images", shown.emitter.size(),
                      shown.modulator.size()),
          layers[l].modulator ? "give one of each per time slot" : "give emitter images only");
    }
    for (std::size_t slot = 0; slot < shown.emitter.size(); ++slot) {
      const bool fits = Fits(shown.emitter[slot], layers[l].emitter) &&
                        (modulators == 0 || Fits(shown.modulator[slot], *layers[l].modulator));
      if (!fits) {
        throw InputError(fmt::format("layer {}, slot {}", l, slot),
                         "shows an image that has not its panel's size",
                         "give images of the panel's pixels");
      }
    }
  }
}

void CheckCamera(const Calibration& calibration, const PrototypeCamera& camera) {
  const Vector3d centre = Centre(camera.camera_from_display);
  for (std::size_t l = 0; l < calibration.layers.size(); ++l) {
    const Rigid& pose = calibration.layers[l].display_from_stack;
    if ((Inverse(pose) * centre).z() > 0) continue;
    throw UsageError("camera",
                     fmt::format("at ({:.6g}, {:.6g}, {:.6g}) mm is not in front of layer {}",
                                 centre.x(), centre.y(), centre.z(), l),
                     "move it towards the viewer (+z)");
  }
  if (camera.aperture_mm > 0 && !(camera.focus_mm > 0)) {
    throw UsageError("camera", "has an aperture but no focus distance", "give focus_mm above 0");
  }
}

// The unit disc from the unit square, area kept (Shirley and Chiu 1997).
Vector2d OnDisc(double u, double v) {
  const double a = 2 * u - 1, b = 2 * v - 1;
  if (a == 0 && b == 0) return {0, 0};
  constexpr double kQuarter = std::numbers::pi / 4;
  if (std::abs(a) > std::abs(b)) {
    return a * Vector2d(std::cos(kQuarter * b / a), std::sin(kQuarter * b / a));
  }
  return b * Vector2d(std::sin(kQuarter * a / b), std::cos(kQuarter * a / b));
}

struct Line {
  Vector3d origin, direction;
};

// The line of sight of a point of the sensor and of the pupil; nothing where the lens sees nothing.
std::optional<Line> LineOfSight(const PrototypeCamera& camera, const Rigid& display_from_camera,
                                const Vector2d& pixel, double u, double v) {
  const std::optional<Vector3d> direction = Unproject(camera.camera, pixel);
  if (!direction) return std::nullopt;
  Line line{Vector3d::Zero(), *direction};
  if (camera.aperture_mm > 0 && direction->z() > 0) {
    const Vector2d pupil = camera.aperture_mm / 2 * OnDisc(u, v);
    line.origin = {pupil.x(), pupil.y(), 0};
    line.direction = camera.focus_mm / direction->z() * *direction - line.origin;
  }
  return Line{display_from_camera * line.origin, display_from_camera.rotation * line.direction};
}

double Illumination(const PrototypeCamera& camera, double x, double y) {
  if (camera.vignetting == 0) return 1;
  const Camera& c = camera.camera;
  const double half = std::hypot(c.width, c.height) / 2;
  const double r = std::hypot(x - c.cx, y - c.cy) / half;
  return std::max(0.0, 1 - camera.vignetting * r * r);
}

float ToFloat(double value) { return static_cast<float>(value); }

// A photograph of each show, block by block.
class Exposing {
 public:
  static constexpr int kBlock = 8;

  Exposing(const Calibration& calibration, std::span<const Show> shows,
           const PrototypeCamera& camera, int samples)
      : camera_(camera),
        shows_(shows),
        layers_(Traced(calibration, shows)),
        display_from_camera_(Inverse(camera.camera_from_display)),
        points_(samples),
        width_(camera.camera.width),
        height_(camera.camera.height) {
    for (std::size_t show = 0; show < shows.size(); ++show) {
      const bool smooth = std::none_of(layers_.begin(), layers_.end(), [&](const auto& layer) {
        return layer.shown[show] && layer.calibration->lattice;
      });
      (smooth && camera.aperture_mm == 0 ? smooth_ : traced_).push_back(show);
    }
  }

  // kBlock rows from `top`, or as many as there are.
  void Expose(int top, std::span<Image<Rgb>> photographs) const {
    Block block;
    for (int left = 0; left < width_; left += kBlock) {
      block.all = {left, top, std::min(kBlock, width_ - left), std::min(kBlock, height_ - top)};
      block.sums.assign(shows_.size() * kBlock * kBlock, {});
      if (!traced_.empty()) AddTraced(layers_, traced_, block.all, block);
      for (const TracedLayer& layer : layers_) {
        if (!smooth_.empty() && !layer.calibration->lattice) AddBetween(layer, block.all, block);
      }
      for (std::size_t show = 0; show < shows_.size(); ++show) {
        if (shows_[show].sheet) AddSheet(show, block);
        Finish(block, show, photographs[show]);
      }
    }
  }

 private:
  struct Block {
    Rect all;
    std::vector<Sum> sums;  // over the samples, one show's after the other's
    Sum& At(std::size_t show, int x, int y) {
      return sums[(show * kBlock + static_cast<std::size_t>(y - all.y)) * kBlock +
                  static_cast<std::size_t>(x - all.x)];
    }
  };

  // From sums over samples to means.
  void Finish(Block& block, std::size_t show, Image<Rgb>& photograph) const {
    for (int y = block.all.y; y < block.all.y + block.all.height; ++y) {
      for (int x = block.all.x; x < block.all.x + block.all.width; ++x) {
        const Sum& sum = block.At(show, x, y);
        const double scale = Illumination(camera_, x + 0.5, y + 0.5) / points_.count();
        photograph(x, y) = {ToFloat(scale * sum.r), ToFloat(scale * sum.g), ToFloat(scale * sum.b)};
      }
    }
  }

  std::optional<Line> Sight(double x, double y, double u, double v) const {
    return LineOfSight(camera_, display_from_camera_, {x, y}, u, v);
  }
  std::optional<SightHit> Hit(const TracedLayer& layer, double x, double y) const {
    const std::optional<Line> line = Sight(x, y, 0.5, 0.5);
    return line ? layer.sights.Seen(line->origin, line->direction) : std::nullopt;
  }
  std::uint64_t HashOf(int x, int y) const {
    return MixedHash(static_cast<std::uint64_t>(std::int64_t{y} * width_ + x));
  }

  void AddSheet(std::size_t show, Block& block) const {
    ForEachLine(block.all, [&](int x, int y, const Line& line) {
      AddLight(*shows_[show].sheet, line.origin, line.direction, block.At(show, x, y));
    });
  }

  // Every sample's line of sight is traced, for some of the shows.
  void AddTraced(std::span<const TracedLayer> layers, const std::vector<std::size_t>& shows,
                 const Rect& rect, Block& block) const {
    ForEachLine(rect, [&](int x, int y, const Line& line) {
      for (const TracedLayer& layer : layers) {
        const std::optional<SightHit> hit = layer.sights.Seen(line.origin, line.direction);
        if (!hit) continue;
        for (const std::size_t show : shows) layer.AddLight(*hit, show, block.At(show, x, y));
      }
    });
  }

  template <class Visit>
  void ForEachLine(const Rect& rect, Visit visit) const {
    for (int y = rect.y; y < rect.y + rect.height; ++y) {
      for (int x = rect.x; x < rect.x + rect.width; ++x) {
        const std::uint64_t hash = HashOf(x, y);
        for (int i = 0; i < points_.count(); ++i) {
          const std::array<double, 4> p = points_.Point(i, hash);
          const std::optional<Line> line = Sight(x + p[0], y + p[1], p[2], p[3]);
          if (line) visit(x, y, *line);
        }
      }
    }
  }

  // The lines between a rectangle's corners, where its middle one is what they make of it.
  std::optional<EvenHits> Even(const TracedLayer& layer, const Rect& rect) const {
    constexpr double kClosePx = 1e-3;
    std::array<SightHit, 4> corners;
    for (int c = 0; c < 4; ++c) {
      const int x = rect.x + (c % 2 == 0 ? 0 : rect.width);
      const int y = rect.y + (c < 2 ? 0 : rect.height);
      const auto hit = Hit(layer, x, y);
      if (!hit) return std::nullopt;
      corners[static_cast<std::size_t>(c)] = *hit;
    }
    const auto middle = Hit(layer, rect.x + 0.5 * rect.width, rect.y + 0.5 * rect.height);
    const EvenHits even(corners);
    const SightHit guess = even.At(0.5, 0.5);
    if (!middle || !((middle->emitter - guess.emitter).norm() < kClosePx) ||
        !((middle->modulator - guess.modulator).norm() < kClosePx)) {
      return std::nullopt;
    }
    return even;
  }

  // Of the smooth shows the same from corners, of ever smaller rectangles until lines turn evenly
  // in them.
  void AddBetween(const TracedLayer& layer, const Rect& rect, Block& block) const {
    if (const std::optional<EvenHits> even = Even(layer, rect)) {
      for (const std::size_t show : smooth_) {
        if (layer.shown[show]) AddEven(layer, *even, rect, show, block);
      }
      return;
    }
    if (rect.width == 1 && rect.height == 1) return AddTraced({&layer, 1}, smooth_, rect, block);
    const int left = (rect.width + 1) / 2, top = (rect.height + 1) / 2;
    for (const int x : {0, left}) {
      for (const int y : {0, top}) {
        const Rect part{rect.x + x, rect.y + y, x == 0 ? left : rect.width - left,
                        y == 0 ? top : rect.height - top};
        if (part.width > 0 && part.height > 0) AddBetween(layer, part, block);
      }
    }
  }

  void AddEven(const TracedLayer& layer, const EvenHits& even, const Rect& rect, std::size_t show,
               Block& block) const {
    const bool one_colour = SeeOneColour(layer, show, even.CornersOf(0, 0, 1, 1));
    const double w = 1.0 / rect.width, h = 1.0 / rect.height;
    for (int j = 0; j < rect.height; ++j) {
      for (int i = 0; i < rect.width; ++i) {
        Sum& sum = block.At(show, rect.x + i, rect.y + j);
        if (one_colour ||
            SeeOneColour(layer, show, even.CornersOf(i * w, j * h, (i + 1) * w, (j + 1) * h))) {
          Sum light;
          layer.AddLight(even.At((i + 0.5) * w, (j + 0.5) * h), show, light);
          sum.Add(points_.count(), light);
          continue;
        }
        const std::uint64_t hash = HashOf(rect.x + i, rect.y + j);
        for (int k = 0; k < points_.count(); ++k) {
          const std::array<double, 4> p = points_.Point(k, hash);
          layer.AddLight(even.At((i + p[0]) * w, (j + p[1]) * h), show, sum);
        }
      }
    }
  }

  const PrototypeCamera& camera_;
  std::span<const Show> shows_;
  std::vector<TracedLayer> layers_;
  Rigid display_from_camera_;
  PixelPoints points_;
  int width_, height_;
  // Shows of which a pinhole's lines of sight go through no lens sheet, and the others.
  std::vector<std::size_t> smooth_, traced_;
};

// One direction of a Gaussian; at the borders the picture goes on as it ends.
Image<Rgb> Spread(const Image<Rgb>& image, const std::vector<float>& half_kernel, bool along_x) {
  Image<Rgb> spread(image.width(), image.height());
  const int reach = static_cast<int>(half_kernel.size()) - 1;
  ParallelForEach(0, image.height(), [&](std::int64_t row) {
    const int y = static_cast<int>(row);
    for (int k = -reach; k <= reach; ++k) {
      const float weight = half_kernel[static_cast<std::size_t>(std::abs(k))];
      const Rgb* from = image.row(along_x ? y : std::clamp(y + k, 0, image.height() - 1));
      Rgb* to = spread.row(y);
      for (int x = 0; x < image.width(); ++x) {
        to[x] += weight * from[along_x ? std::clamp(x + k, 0, image.width() - 1) : x];
      }
    }
  });
  return spread;
}

Image<Rgb> Blurred(Image<Rgb> image, double sigma_px) {
  std::vector<double> half = {1};
  double total = 1;
  for (int k = 1; k <= static_cast<int>(std::ceil(4 * sigma_px)); ++k) {
    half.push_back(std::exp(-0.5 * k * k / (sigma_px * sigma_px)));
    total += 2 * half.back();
  }
  std::vector<float> kernel;
  for (const double weight : half) kernel.push_back(ToFloat(weight / total));
  image = Spread(image, kernel, true);
  return Spread(image, kernel, false);
}

// Pixels of `image` in squares of `side`, each square's mean.
Image<Rgb> Means(const Image<Rgb>& image, int side) {
  Image<Rgb> means(image.width() / side, image.height() / side);
  const float weight = 1 / static_cast<float>(side * side);
  for (int y = 0; y < image.height(); ++y) {
    for (int x = 0; x < image.width(); ++x) means(x / side, y / side) += weight * image(x, y);
  }
  return means;
}

// `samples` lines of sight for `side` x `side` pixels, rounded up; progress, by `side` rows of
// every photograph.
std::vector<Image<Rgb>> Expose(const Calibration& calibration, std::span<const Show> shows,
                               const PrototypeCamera& camera, int samples, int side,
                               Progress& progress) {
  const Exposing exposing(calibration, shows, camera, (samples + side * side - 1) / (side * side));
  const int height = camera.camera.height;
  std::vector<Image<Rgb>> photographs;
  for (std::size_t i = 0; i < shows.size(); ++i) {
    photographs.emplace_back(camera.camera.width, height);
  }
  constexpr int kRows = Exposing::kBlock;
  ParallelForEach(0, (height + kRows - 1) / kRows, [&](std::int64_t block) {
    const int top = static_cast<int>(block) * kRows;
    exposing.Expose(top, photographs);
    const int rows = (std::min(top + kRows, height) - top + side - 1) / side;
    progress.Advance(rows * static_cast<std::int64_t>(shows.size()));
  });
  return photographs;
}

}  // namespace

std::vector<Image<Rgb>> PhotographShows(const Calibration& calibration, std::span<const Show> shows,
                                        const PrototypeCamera& camera, int samples,
                                        Progress& progress) {
  Check(calibration, calibration.display);
  for (const Show& show : shows) CheckShown(calibration.layers, show);
  CheckCamera(calibration, camera);
  if (!(camera.blur_px > 0)) return Expose(calibration, shows, camera, samples, 1, progress);
  // A lens spreads light before there are pixels. Pixels that are spread have aliases of the edges
  // in them: at 1 px corners are found 0.008 px aside by where between pixels they are.
  constexpr int kSide = 2;
  PrototypeCamera fine = camera;
  fine.camera = Resized(camera.camera, kSide);
  std::vector<Image<Rgb>> photographs = Expose(calibration, shows, fine, samples, kSide, progress);
  for (Image<Rgb>& photograph : photographs) {
    photograph = Means(Blurred(std::move(photograph), kSide * camera.blur_px), kSide);
  }
  return photographs;
}

Image<Rgb> PhotographPrototype(const Prototype& prototype, const PrototypeCamera& camera,
                               int samples, Progress& progress) {
  const Show show{prototype.shown, prototype.sheet};
  return std::move(
      PhotographShows(prototype.calibration, {&show, 1}, camera, samples, progress).front());
}

Rgb LightAlong(const Prototype& prototype, const Vector3d& origin, const Vector3d& direction) {
  const Show show{prototype.shown, {}};
  Sum sum;
  for (const TracedLayer& layer : Traced(prototype.calibration, {&show, 1})) {
    const std::optional<SightHit> hit = layer.sights.Seen(origin, direction);
    if (hit) layer.AddLight(*hit, 0, sum);
  }
  return {ToFloat(sum.r), ToFloat(sum.g), ToFloat(sum.b)};
}

}  // namespace lamella
