#include "datasets_synthetic/prototype.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <memory>
#include <mutex>
#include <numbers>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "datasets_synthetic/corner_hits.h"
#include "datasets_synthetic/lens_spread.h"
#include "datasets_synthetic/pixel_points.h"
#include "datasets_synthetic/traced_layer.h"
#include "lightfield/error.h"
#include "lightfield/parallel.h"

namespace lamella {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

// Light of the sheet along a line of sight.
void AddLight(const PrintedSheet& sheet, const Vector3d& origin, const Vector3d& direction,
              double weight, LightSum& sum) {
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
  if (x && y) sum.Add(weight, light(*x, *y));
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

// A photograph of each show, tile by tile.
class Exposing {
 public:
  static constexpr int kTile = 32;

  Exposing(const Calibration& calibration, std::span<const Show> shows,
           const PrototypeCamera& camera, int samples)
      : camera_(camera),
        shows_(shows),
        layers_(LitLayers(calibration, shows)),
        display_from_camera_(Inverse(camera.camera_from_display)),
        points_(samples),
        width_(camera.camera.width) {
    for (std::size_t show = 0; show < shows.size(); ++show) {
      const bool smooth = std::none_of(layers_.begin(), layers_.end(), [&](const auto& layer) {
        return layer.IsLit(show) && layer.HasLenses();
      });
      (smooth && camera.aperture_mm == 0 ? smooth_ : traced_).push_back(show);
    }
  }

  // Rows from `top`, kTile of them or as many as there are before `end`, into the first rows of a
  // strip for each show. Returns their number.
  int Expose(int top, int end, std::span<Image<Rgb>> strips) const {
    Tile tile(shows_.size());
    const int rows = std::min(kTile, end - top);
    for (int left = 0; left < width_; left += kTile) {
      tile.Move({left, top, std::min(kTile, width_ - left), rows});
      if (!traced_.empty()) AddTraced(layers_, traced_, tile.all, tile);
      for (const TracedLayer& layer : layers_) {
        if (!smooth_.empty() && !layer.HasLenses()) AddSmooth(layer, tile.all, tile);
      }
      for (std::size_t show = 0; show < shows_.size(); ++show) {
        if (shows_[show].sheet) AddSheet(show, tile);
        Finish(tile, show, strips[show]);
      }
    }
    return rows;
  }

 private:
  // The light on a rectangle's pixels, one show's after the other's.
  struct Tile {
    Rect all;
    std::vector<LightSum> sums;
    std::vector<char> lit;  // by each show; where not, its sums are 0

    explicit Tile(std::size_t num_shows) : sums(num_shows * kTile * kTile), lit(num_shows) {}
    void Move(const Rect& to) {
      all = to;
      for (std::size_t show = 0; show < lit.size(); ++show) {
        if (lit[show]) std::fill_n(sums.begin() + FirstOf(show), kTile * kTile, LightSum());
        lit[show] = false;
      }
    }
    LightSum& At(std::size_t show, int x, int y) {
      lit[show] = true;
      return sums[static_cast<std::size_t>(FirstOf(show) + (y - all.y) * kTile + x - all.x)];
    }
    static std::ptrdiff_t FirstOf(std::size_t show) {
      return static_cast<std::ptrdiff_t>(show) * kTile * kTile;
    }
  };

  void Finish(Tile& tile, std::size_t show, Image<Rgb>& strip) const {
    for (int y = tile.all.y; y < tile.all.y + tile.all.height; ++y) {
      Rgb* row = strip.row(y - tile.all.y) + tile.all.x;
      if (!tile.lit[show]) {
        std::fill_n(row, tile.all.width, Rgb());
        continue;
      }
      for (int x = tile.all.x; x < tile.all.x + tile.all.width; ++x) {
        const LightSum& sum = tile.At(show, x, y);
        const double scale = Illumination(camera_, x + 0.5, y + 0.5);
        *row++ = {ToFloat(scale * sum.r), ToFloat(scale * sum.g), ToFloat(scale * sum.b)};
      }
    }
  }

  std::optional<Line> Sight(double x, double y, double u, double v) const {
    return LineOfSight(camera_, display_from_camera_, {x, y}, u, v);
  }
  std::uint64_t HashOf(int x, int y) const {
    return MixedHash(static_cast<std::uint64_t>(std::int64_t{y} * width_ + x));
  }
  double SampleWeight() const { return 1.0 / points_.count(); }

  void AddSheet(std::size_t show, Tile& tile) const {
    ForEachLine(tile.all, [&](int x, int y, const Line& line) {
      AddLight(*shows_[show].sheet, line.origin, line.direction, SampleWeight(),
               tile.At(show, x, y));
    });
  }

  // Every sample's line of sight is traced, for some of the shows.
  void AddTraced(std::span<const TracedLayer> layers, std::span<const std::size_t> shows,
                 const Rect& rect, Tile& tile) const {
    ForEachLine(rect, [&](int x, int y, const Line& line) {
      for (const TracedLayer& layer : layers) {
        const std::optional<SightHit> hit = layer.sights().Seen(line.origin, line.direction);
        if (!hit) continue;
        for (const std::size_t show : shows) {
          layer.AddLight(*hit, show, SampleWeight(), tile.At(show, x, y));
        }
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

  // Visits the quarters of a rectangle of more than a pixel, or halves where it is one pixel thick.
  template <class Visit>
  static void ForEachQuarter(const Rect& rect, Visit visit) {
    const int left = (rect.width + 1) / 2, top = (rect.height + 1) / 2;
    for (const int x : {0, left}) {
      for (const int y : {0, top}) {
        const Rect part{rect.x + x, rect.y + y, x == 0 ? left : rect.width - left,
                        y == 0 ? top : rect.height - top};
        if (part.width > 0 && part.height > 0) visit(part);
      }
    }
  }

  // Of the smooth shows the same from corners of pixels, of ever smaller rectangles until lines
  // turn smoothly in them.
  void AddSmooth(const TracedLayer& layer, const Rect& rect, Tile& tile) const {
    std::vector<std::size_t> shows;
    std::copy_if(smooth_.begin(), smooth_.end(), std::back_inserter(shows),
                 [&](std::size_t show) { return layer.IsLit(show); });
    if (shows.empty()) return;
    const auto hits = CornerHits::Between(rect, [&](double x, double y) {
      const std::optional<Line> line = Sight(x, y, 0.5, 0.5);
      return line ? layer.sights().Seen(line->origin, line->direction) : std::nullopt;
    });
    if (hits) return AddAreas(layer, *hits, rect, shows, tile);
    if (rect.width == 1 && rect.height == 1) return AddTraced({&layer, 1}, shows, rect, tile);
    ForEachQuarter(rect, [&](const Rect& part) { AddSmooth(layer, part, tile); });
  }

  // Into ever smaller rectangles until each is one light or a pixel. Reorders `shows`.
  void AddAreas(const TracedLayer& layer, const CornerHits& hits, const Rect& rect,
                std::span<std::size_t> shows, Tile& tile) const {
    const PanelsUnder under = layer.Under(hits, rect);
    const auto rest = std::partition(shows.begin(), shows.end(), [&](std::size_t show) {
      return layer.IsOneLight(show, under);
    });
    for (const std::size_t show : std::span(shows.begin(), rest)) {
      Fill(layer, hits, rect, show, tile);
    }
    const std::span<std::size_t> uneven(rest, shows.end());
    if (uneven.empty()) return;
    if (rect.width == 1 && rect.height == 1) {
      for (const std::size_t show : uneven) AddPixel(layer, hits, under, rect, show, tile);
    } else {
      ForEachQuarter(rect, [&](const Rect& part) { AddAreas(layer, hits, part, uneven, tile); });
    }
  }

  // With one light.
  void Fill(const TracedLayer& layer, const CornerHits& hits, const Rect& rect, std::size_t show,
            Tile& tile) const {
    LightSum light;
    layer.AddLight(hits.Within(rect.x, rect.y, 0.5, 0.5), show, 1, light);
    if (light == LightSum()) return;
    for (int y = rect.y; y < rect.y + rect.height; ++y) {
      for (int x = rect.x; x < rect.x + rect.width; ++x) {
        LightSum& sum = tile.At(show, x, y);
        if (layer.FallsOff()) {
          layer.AddLight(hits.Within(x, y, 0.5, 0.5), show, 1, sum);
        } else {
          sum.Add(1, light);
        }
      }
    }
  }

  void AddPixel(const TracedLayer& layer, const CornerHits& hits, const PanelsUnder& under,
                const Rect& pixel, std::size_t show, Tile& tile) const {
    const int x = pixel.x, y = pixel.y;
    LightSum& sum = tile.At(show, x, y);
    if (layer.AddMean(show, under, hits, x, y, sum)) return;
    const std::uint64_t hash = HashOf(x, y);
    for (int i = 0; i < points_.count(); ++i) {
      const std::array<double, 4> p = points_.Point(i, hash);
      layer.AddLight(hits.Within(x, y, p[0], p[1]), show, SampleWeight(), sum);
    }
  }

  const PrototypeCamera& camera_;
  std::span<const Show> shows_;
  std::vector<TracedLayer> layers_;
  Rigid display_from_camera_;
  PixelPoints points_;
  int width_;
  // Shows of which a pinhole's lines of sight go through no lens sheet, and the others.
  std::vector<std::size_t> smooth_, traced_;
};

std::vector<Image<Rgb>> Blank(std::size_t count, int width, int height) {
  std::vector<Image<Rgb>> images;
  for (std::size_t i = 0; i < count; ++i) images.emplace_back(width, height);
  return images;
}

// Takes photographs band by band: what is exposed of a band, in half pixels and a lens's reach
// further, becomes pixels before the next one is. So whole pictures of half pixels, four times the
// photographs' memory, are never there.
class Shooting {
 public:
  // `spread` is null where there are no half pixels.
  Shooting(const Exposing& exposing, const LensSpread* spread, std::vector<Image<Rgb>>& photographs)
      : exposing_(exposing),
        spread_(spread),
        photographs_(photographs),
        width_(photographs[0].width()),
        height_(photographs[0].height()),
        side_(spread ? LensSpread::kSide : 1),
        reach_(spread ? spread->reach() : 0),
        // So high that rows of its neighbours are few beside its own.
        band_rows_(spread ? std::max(64, 4 * reach_) : Exposing::kTile) {}

  void Shoot(Progress& progress) {
    ParallelForEach(0, (height_ + band_rows_ - 1) / band_rows_, [&](std::int64_t band) {
      const int first = static_cast<int>(band) * band_rows_;
      std::unique_ptr<Desk> desk = TakeDesk();
      ShootBand(first, std::min(first + band_rows_, height_), *desk, progress);
      const std::scoped_lock lock(free_mutex_);
      free_.push_back(std::move(desk));
    });
  }

 private:
  // What a thread works on: of every show some rows as exposed, and a band spread along x.
  struct Desk {
    std::vector<Image<Rgb>> strips, bands;
  };

  // Memory is as dear as work: desks are used again.
  std::unique_ptr<Desk> TakeDesk() {
    {
      const std::scoped_lock lock(free_mutex_);
      if (!free_.empty()) {
        std::unique_ptr<Desk> desk = std::move(free_.back());
        free_.pop_back();
        return desk;
      }
    }
    const std::size_t shows = photographs_.size();
    const int rows = side_ * std::min(band_rows_, height_) + 2 * reach_;
    return std::make_unique<Desk>(Desk{Blank(shows, side_ * width_, Exposing::kTile),
                                       Blank(spread_ ? shows : 0, width_, rows)});
  }

  // Rows `first` to `end` of the photographs.
  void ShootBand(int first, int end, Desk& desk, Progress& progress) const {
    const int top = std::max(side_ * first - reach_, 0),
              bottom = std::min(side_ * end + reach_, side_ * height_);
    for (int y = top; y < bottom; y += Exposing::kTile) {
      const int rows = exposing_.Expose(y, bottom, desk.strips);
      for (int row = 0; row < rows; ++row) PutRow(row, y + row - top, first, desk);
    }
    if (spread_) {
      for (std::size_t show = 0; show < photographs_.size(); ++show) {
        for (int y = first; y < end; ++y) {
          spread_->AlongY(desk.bands[show], top, side_ * height_, y, photographs_[show].row(y));
        }
      }
    }
    progress.Advance((end - first) * std::ssize(photographs_));
  }

  // A strip's row, which is such a one of the band.
  void PutRow(int strip_row, int band_row, int first, Desk& desk) const {
    for (std::size_t show = 0; show < photographs_.size(); ++show) {
      const Rgb* row = desk.strips[show].row(strip_row);
      if (spread_) {
        spread_->AlongX(row, width_, desk.bands[show].row(band_row));
      } else {
        std::copy_n(row, width_, photographs_[show].row(first + band_row));
      }
    }
  }

  const Exposing& exposing_;
  const LensSpread* spread_;
  std::vector<Image<Rgb>>& photographs_;
  int width_, height_, side_, reach_, band_rows_;
  std::mutex free_mutex_;
  std::vector<std::unique_ptr<Desk>> free_;
};

}  // namespace

std::vector<Image<Rgb>> PhotographShows(const Calibration& calibration, std::span<const Show> shows,
                                        const PrototypeCamera& camera, int samples,
                                        Progress& progress) {
  Check(calibration, calibration.display);
  for (const Show& show : shows) CheckShown(calibration.layers, show);
  CheckCamera(calibration, camera);
  std::vector<Image<Rgb>> photographs =
      Blank(shows.size(), camera.camera.width, camera.camera.height);
  if (shows.empty()) return photographs;
  if (!(camera.blur_px > 0)) {
    const Exposing exposing(calibration, shows, camera, samples);
    Shooting(exposing, nullptr, photographs).Shoot(progress);
    return photographs;
  }
  constexpr int kSide = LensSpread::kSide;
  PrototypeCamera fine = camera;
  fine.camera = Resized(camera.camera, kSide);
  const Exposing exposing(calibration, shows, fine,
                          (samples + kSide * kSide - 1) / (kSide * kSide));
  const LensSpread spread(camera.blur_px);
  Shooting(exposing, &spread, photographs).Shoot(progress);
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
  LightSum sum;
  for (const TracedLayer& layer : LitLayers(prototype.calibration, {&show, 1})) {
    const std::optional<SightHit> hit = layer.sights().Seen(origin, direction);
    if (hit) layer.AddLight(*hit, 0, 1, sum);
  }
  return {ToFloat(sum.r), ToFloat(sum.g), ToFloat(sum.b)};
}

}  // namespace lamella
