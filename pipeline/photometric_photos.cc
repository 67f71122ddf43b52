#include "pipeline/photometric_photos.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <tuple>
#include <utility>

#include <fmt/format.h>

#include "calibration/camera_response.h"
#include "calibration/detect_board.h"
#include "calibration/homography.h"
#include "lightfield/color.h"
#include "lightfield/error.h"
#include "lightfield/image_io.h"
#include "pipeline/calibration_patterns.h"
#include "pipeline/image_folder.h"
#include "pipeline/panel_region.h"
#include "pipeline/photo_numbers.h"

namespace lamella {
namespace fs = std::filesystem;
namespace {

using Kind = PatternShot::Kind;

constexpr int kReadCells = kGainColumns * kGainRows;
constexpr int kLeastPx = 2000;      // of a panel
constexpr int kLeastPatchPx = 100;  // of a patch of lines
constexpr double kMostSaturated = 1e-3;

// Numbers through a camera's curve.
void MakeLinear(const CameraResponse& response, Image<Rgb>& photo) {
  constexpr int kSteps = 4080;  // 16 between codes of 8 bits
  std::vector<float> table;
  for (int i = 0; i <= kSteps; ++i) {
    table.push_back(static_cast<float>(response.LightOf(static_cast<double>(i) / kSteps)));
  }
  const auto light = [&](float number) {
    return table[static_cast<std::size_t>(std::lround(std::clamp(number, 0.0F, 1.0F) * kSteps))];
  };
  for (std::size_t i = 0; i < photo.size(); ++i) {
    Rgb& pixel = photo.data()[i];
    pixel = {light(pixel.r), light(pixel.g), light(pixel.b)};
  }
}

Image<Rgb> ReadPhoto(const fs::path& file, PhotoCurve curve,
                     const std::optional<CameraResponse>& response) {
  const ImageInfo info = ReadImageInfo(file);
  if (curve != PhotoCurve::kEstimated && !info.is_float && info.bits <= 8) {
    throw InputError(file.string(),
                     "has 8 bits and so a tone curve that is not known: were its exponent off by "
                     "5 %, gamma would be by 0.11 and black by a third",
                     "develop the raw files to linear 16-bit TIFF or PNG, or EXR; or let the curve "
                     "be estimated, gamma to 0.02: --curve estimate");
  }
  if (curve == PhotoCurve::kSrgb) return ReadImage(file);
  Image<Rgb> photo = ReadNumbers(file);
  if (response && !info.is_float) MakeLinear(*response, photo);
  return photo;
}

bool IsLevel(const PatternShot& shot) {
  const Rgb8& color = shot.pattern.color;
  return shot.kind == Kind::kFlat && color.r == color.g && color.g == color.b;
}

// Reads photographs one after the other and keeps what later ones need.
class Reader {
 public:
  Reader(ShotList list, PhotoCurve curve, std::optional<CameraResponse> response)
      : curve_(curve), response_(std::move(response)) {
    light_.list = std::move(list);
    light_.exposures = {1};
    for (const PatternShot& shot : light_.list.shots) {
      if (shot.exposure != light_.exposures.back() && ExposureIndex(shot.exposure) < 0) {
        light_.exposures.push_back(shot.exposure);
      }
      if (shot.kind == Kind::kWhite && !IndexOfLayer(shot.panel.layer)) {
        light_.layers.push_back({shot.panel.layer, {}, {}, 0, 0, {}, {}});
        light_.layers.back().colors.assign(kReadCells, Eigen::Matrix3d::Zero());
      }
    }
    light_.boards.cameras.push_back({"body", 0, 0, 0});
  }

  void Begin(int view) {
    view_ = view;
    light_.num_views = view + 1;
    darks_.clear();
    regions_.clear();
  }

  void Add(const fs::path& file, const PatternShot& shot) {
    file_ = file;
    const Image<Rgb> photo = ReadPhoto(file, curve_, response_);
    CheckSize(photo);
    if (shot.kind == Kind::kDark) {
      darks_[shot.exposure] = photo.Clone();
      return;
    }
    if (shot.kind == Kind::kBoard) return AddBoard(photo, shot);
    const std::optional<std::size_t> index = IndexOfLayer(shot.panel.layer);
    if (!index) return;
    AddLight(photo, shot, light_.layers[*index]);
  }

  // What the camera's curve is estimated from.
  const std::vector<NumberReading>& numbers() const { return numbers_; }

  PhotometricLight Finish() {
    if (response_) light_.curve_rms = response_->rms;
    for (LayerLight& layer : light_.layers) {
      std::vector<Eigen::VectorXd>& lines = lines_[layer.layer];
      const auto usable = [](const Eigen::VectorXd& series) { return series.sum() > 0; };
      std::copy_if(lines.begin(), lines.end(), std::back_inserter(layer.lines), usable);
    }
    for (const auto& [panel, count] : overexposed_) {
      light_.left_out.push_back(
          fmt::format("{}: {} overexposed level{}", NameOf(panel), count, count == 1 ? "" : "s"));
    }
    return std::move(light_);
  }

 private:
  int ExposureIndex(int factor) const {
    const auto at = std::find(light_.exposures.begin(), light_.exposures.end(), factor);
    return at == light_.exposures.end() ? -1 : static_cast<int>(at - light_.exposures.begin());
  }
  std::optional<std::size_t> IndexOfLayer(int layer) const {
    for (std::size_t i = 0; i < light_.layers.size(); ++i) {
      if (light_.layers[i].layer == layer) return i;
    }
    return std::nullopt;
  }
  const CalibratedPanel& PanelOf(const PanelId& id) const {
    return *std::find_if(light_.list.panels.begin(), light_.list.panels.end(),
                         [&](const CalibratedPanel& panel) { return panel.id == id; });
  }

  void CheckSize(const Image<Rgb>& photo) {
    if (light_.width == 0) {
      first_ = file_.filename().string();
      light_.width = photo.width();
      light_.height = photo.height();
      light_.boards.cameras[0].width = photo.width();
      light_.boards.cameras[0].height = photo.height();
    }
    CheckSameSize({file_.string(), photo.width(), photo.height()},
                  {first_, light_.width, light_.height});
  }

  void AddBoard(const Image<Rgb>& photo, const PatternShot& shot) {
    Image<float> luminance(photo.width(), photo.height());
    for (std::size_t i = 0; i < photo.size(); ++i) {
      luminance.data()[i] = Luminance(photo.data()[i]);
    }
    const CalibratedPanel& panel = PanelOf(shot.panel);
    std::optional<BoardSighting> seen;
    if (panel.board) seen = DetectBoard(luminance.span(), {*panel.board});
    std::optional<Eigen::Matrix3d> image_from_panel;
    if (seen) image_from_panel = Homography(seen->points);
    if (!image_from_panel) {
      throw InputError(file_.string(),
                       fmt::format("does not show the board of {}, as shot {} does",
                                   NameOf(shot.panel), shot.name),
                       "photographs must sort by name as they were taken, none missing");
    }
    light_.boards.photos.push_back(
        {shot.panel, view_, 0, file_.filename().string(), std::move(seen->points)});
    if (shot.panel.role != PanelId::kEmitter) return;
    PanelRegion region = RegionOf(*image_from_panel, panel.size, light_.width, light_.height);
    if (region.num_px < kLeastPx) {
      throw InputError(file_.string(),
                       fmt::format("shows {} on {} px only", NameOf(shot.panel), region.num_px),
                       fmt::format("go nearer: {} are needed", kLeastPx));
    }
    regions_.insert_or_assign(shot.panel.layer, std::move(region));
  }

  static std::optional<Eigen::Matrix3d> Homography(const std::vector<Observation>& points) {
    Eigen::Matrix2Xd panel(2, points.size()), image(2, points.size());
    for (std::size_t i = 0; i < points.size(); ++i) {
      panel.col(static_cast<Eigen::Index>(i)) = points[i].panel_px;
      image.col(static_cast<Eigen::Index>(i)) = points[i].image_px;
    }
    return FitHomography(panel, image);
  }

  void AddLight(const Image<Rgb>& photo, const PatternShot& shot, LayerLight& layer) {
    const auto found = regions_.find(layer.layer);
    const auto dark_found = darks_.find(shot.exposure);
    if (found == regions_.end() || dark_found == darks_.end()) {
      throw InputError(file_.string(),
                       "comes before the dark photograph of its exposure or its emitter's board",
                       "make the patterns again: their list is not in order");
    }
    const PanelRegion& region = found->second;
    const ImageSpan<const Rgb> dark = dark_found->second.span();
    if (curve_ == PhotoCurve::kEstimated && !response_) return AddNumbers(photo, shot, region);
    if (shot.kind == Kind::kLines) return AddLines(photo, dark, shot, region);
    const RegionLight light = LightOf(photo.span(), dark, region);
    const bool overexposed = light.saturated > kMostSaturated;
    const bool is_level = IsLevel(shot);
    if (overexposed && is_level) {
      ++overexposed_[shot.panel];
      return;
    }
    if (overexposed) {
      throw InputError(
          file_.string(),
          fmt::format("{:.1f} % of {} is overexposed", 100 * light.saturated, NameOf(shot.panel)),
          "expose all shots less, white at about 80 % of full scale");
    }
    if (shot.kind == Kind::kWhite) return AddWhite(light, region, layer);
    if (shot.kind == Kind::kMixed) {
      layer.mixed = light.sum;
    } else if (is_level) {
      (shot.panel.role == PanelId::kEmitter ? layer.emitter : layer.modulator)
          .push_back({shot.pattern.color.g / 255.0, ExposureIndex(shot.exposure), light.sum,
                      light.variance});
    } else {
      const Rgb8& color = shot.pattern.color;
      const Eigen::Index column = color.r > 0 ? 0 : color.g > 0 ? 1 : 2;
      for (std::size_t c = 0; c < kReadCells; ++c) layer.colors[c].col(column) = light.cells[c];
    }
  }

  // Green ones, as they are, of cells in which the light is nearly even.
  void AddNumbers(const Image<Rgb>& photo, const PatternShot& shot, const PanelRegion& region) {
    if (!IsLevel(shot) && shot.kind != Kind::kWhite) return;
    const Image<Rgb> none(photo.width(), photo.height());
    const RegionLight light = LightOf(photo.span(), none.span(), region);
    const int code = shot.kind == Kind::kWhite ? 255 : shot.pattern.color.g;
    for (const int cell : {10, 20, 29}) {
      const auto c = static_cast<std::size_t>(cell);
      const std::tuple<PanelId, int, int> light_of{shot.panel, code, cell};
      const int patch = patches_.emplace(light_of, static_cast<int>(patches_.size())).first->second;
      numbers_.push_back({patch, static_cast<double>(shot.exposure), light.cells[c].y(),
                          light.variance * region.num_px / std::max(1, region.cell_px[c])});
    }
  }

  void AddWhite(const RegionLight& light, const PanelRegion& region, LayerLight& layer) {
    for (std::size_t c = 0; c < kReadCells; ++c) {
      if (region.cell_px[c] == 0) continue;
      // The cells' noise is the panel's, of fewer pixels.
      const double variance = light.variance * region.num_px / region.cell_px[c];
      light_.whites.push_back({layer.layer, view_, static_cast<int>(c), light.cells[c].sum(),
                               variance, region.cell_image[c], region.cell_panel[c]});
    }
    if (view_ > 0) return;
    layer.white = light.sum;
    layer.emitter.push_back({1, 0, light.sum, light.variance});
    layer.modulator.push_back({1, 0, light.sum, light.variance});
  }

  void AddLines(const Image<Rgb>& photo, const ImageSpan<const Rgb>& dark, const PatternShot& shot,
                const PanelRegion& region) {
    const std::vector<double> patches = PatchLightOf(photo.span(), dark, region);
    std::vector<Eigen::VectorXd>& lines = lines_[shot.panel.layer];
    lines.resize(kReadCells, Eigen::VectorXd::Zero(kLinesPeriodPx));
    for (std::size_t c = 0; c < kReadCells; ++c) {
      if (region.patch_px[c] >= kLeastPatchPx) lines[c](shot.pattern.step) = patches[c];
    }
  }

  PhotoCurve curve_;
  std::optional<CameraResponse> response_;  // of kEstimated; none while it is not known
  std::vector<NumberReading> numbers_;
  std::map<std::tuple<PanelId, int, int>, int> patches_;  // panel, code and cell
  PhotometricLight light_;
  int view_ = 0;
  fs::path file_;
  std::string first_;                                  // photograph
  std::map<int, Image<Rgb>> darks_;                    // of each exposure, at this position
  std::map<int, PanelRegion> regions_;                 // of each layer's emitter, at this position
  std::map<int, std::vector<Eigen::VectorXd>> lines_;  // of each layer, of each cell
  std::map<PanelId, int> overexposed_;
};

std::vector<const PatternShot*> Everywhere(const ShotList& list) {
  std::vector<const PatternShot*> shots;
  for (const PatternShot& shot : list.shots) {
    if (!shot.first_position_only) shots.push_back(&shot);
  }
  return shots;
}

void CheckNumber(std::size_t photos, std::size_t first, std::size_t further,
                 const fs::path& folder) {
  if (photos >= first && (photos - first) % further == 0) return;
  throw InputError(folder.string(),
                   fmt::format("has {} photographs, not {} and {} from every further position",
                               photos, first, further),
                   "give all shots of shots.txt once each, and nothing else");
}

}  // namespace

PhotometricLight ReadPhotometricPhotos(const fs::path& patterns, const fs::path& photos,
                                       PhotoCurve curve, Progress& progress) {
  const ShotList list = LoadShotList(patterns);
  if (list.mode != CalibrationMode::kPhotometry) {
    throw UsageError(patterns.string(), "has no patterns of photometry",
                     "make them: lamella calibrate patterns --mode photometry");
  }
  const std::vector<NamedFile> files = ImagesOf(photos);
  const std::vector<const PatternShot*> further = Everywhere(list);
  CheckNumber(files.size(), list.shots.size(), further.size(), photos);
  progress.Start("photographs", static_cast<std::int64_t>(files.size()), "photographs");
  std::optional<CameraResponse> response;
  if (curve == PhotoCurve::kEstimated) {
    Reader probe(list, curve, std::nullopt);
    probe.Begin(0);
    for (std::size_t i = 0; i < list.shots.size(); ++i) probe.Add(files[i].path, list.shots[i]);
    response = EstimateCameraResponse(probe.numbers(), photos.string());
  }
  Reader reader(list, curve, std::move(response));
  std::size_t next = 0;
  for (int view = 0; next < files.size(); ++view) {
    reader.Begin(view);
    const std::size_t count = view == 0 ? list.shots.size() : further.size();
    for (std::size_t i = 0; i < count; ++i, ++next) {
      reader.Add(files[next].path, view == 0 ? list.shots[i] : *further[i]);
      progress.Advance();
    }
  }
  return reader.Finish();
}

}  // namespace lamella
