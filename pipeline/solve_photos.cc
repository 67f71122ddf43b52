#include "pipeline/solve_photos.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <system_error>
#include <utility>

#include <fmt/format.h>

#include "distribute/displays.h"
#include "distribute/simulate_eye.h"
#include "lightfield/error.h"
#include "lightfield/hash.h"
#include "pipeline/calibration_patterns.h"
#include "pipeline/check_photos.h"
#include "pipeline/observe_photos.h"

namespace lamella {
namespace fs = std::filesystem;
namespace {

void CheckAnyUsable(const CheckedPhotos& checked, const fs::path& photos) {
  const CheckedPhoto* first = nullptr;  // that should have been usable
  for (const CheckedPhoto& photo : checked.photos) {
    if (!photo.shot) continue;
    const PatternShot::Kind kind = checked.list.shots[*photo.shot].kind;
    if (photo.usable || (photo.good && kind == PatternShot::Kind::kPhase)) return;
    if (first == nullptr && kind == PatternShot::Kind::kBoard) first = &photo;
  }
  throw InputError(
      photos.string(),
      fmt::format(
          "none of its {} photographs shows a panel of display {} well enough{}",
          checked.photos.size(), checked.list.display,
          first == nullptr ? std::string() : fmt::format("; {}: {}", first->photo, first->verdict)),
      "give the photographs of these very patterns; `lamella calibrate check` judges each");
}

// Which photographs were not used or are not as good as they could be.
void ListDoubts(const CheckedPhotos& checked, SolvedPhotos& solved) {
  for (const CheckedPhoto& photo : checked.photos) {
    if (photo.good || (photo.shot && checked.list.shots[*photo.shot].again)) continue;
    (photo.usable ? solved.doubtful : solved.left_out)
        .push_back(photo.photo + ": " + photo.verdict);
  }
  for (const MovedPosition& moved : MovedPositions(checked)) {
    solved.left_out.push_back(
        fmt::format("position {}: the camera moved by {:.2f} px while it was there: take the "
                    "position anew",
                    moved.view + 1, moved.moved_px));
  }
}

}  // namespace

Display DisplayToSolve(const SolvePhotosOptions& options) {
  if (!options.display.empty()) return FindDisplay(options.display);
  const fs::path beside = options.patterns / kPatternsDisplay;
  std::error_code error;
  return fs::exists(beside, error) ? ReadDisplay(beside)
                                   : FindDisplay(LoadShotList(options.patterns).display);
}

// The panels that the patterns were made for are the design's.
void CheckDesign(const Calibration& design, const ShotList& list, const std::string& where) {
  for (const CalibratedPanel& panel : list.panels) {
    const auto i = static_cast<std::size_t>(panel.id.layer);
    const PanelCalibration* built = nullptr;
    if (i < design.layers.size()) {
      const LayerCalibration& layer = design.layers[i];
      if (panel.id.role == PanelId::kEmitter) built = &layer.emitter;
      if (panel.id.role == PanelId::kModulator && layer.modulator) built = &*layer.modulator;
    }
    if (built != nullptr && built->width_px == panel.size.width_px &&
        built->height_px == panel.size.height_px && built->mirror_x == panel.mirrored) {
      continue;
    }
    throw UsageError(
        where,
        fmt::format("display {} has no {} of {} x {} px{}, for which these patterns "
                    "of {} were made",
                    design.display, NameOf(panel.id), panel.size.width_px, panel.size.height_px,
                    panel.mirrored ? " seen in a mirror" : "", list.display),
        "give --display the file that the patterns were made of");
  }
}

EyeBox EyesOf(const Display& display) {
  constexpr double kEyesApartMm = 65;
  EyeBox box;
  const double clean = CleanEyeBox(display);
  box.half_width_mm = box.half_height_mm =
      std::max(kEyesApartMm / 2, std::isfinite(clean) ? clean : 0);
  box.near_mm = 0.8 * display.viewing_distance_mm;
  box.far_mm = 1.2 * display.viewing_distance_mm;
  return box;
}

std::vector<SolvedPhotos::Photo> HashPhotos(const std::set<std::string>& names,
                                            const fs::path& photos) {
  const fs::path folder = fs::is_directory(photos) ? photos : photos.parent_path();
  std::vector<SolvedPhotos::Photo> hashed;
  for (const std::string& name : names) hashed.push_back({name, Sha256OfFile(folder / name)});
  return hashed;
}

SolvedPhotos SolvePhotos(const SolvePhotosOptions& options, Progress& progress) {
  const ShotList list = LoadShotList(options.patterns);
  SolvedPhotos solved;
  solved.display = DisplayToSolve(options);
  if (!options.cameras.empty()) {
    throw UsageError("--cameras", "is for varifocal displays: this one's panels tell poses",
                     "leave it out");
  }
  const Calibration design = DesignCalibration(solved.display);
  CheckDesign(design, list, options.display.empty() ? options.patterns.string() : options.display);
  const CheckedPhotos checked = CheckPhotos(
      options.patterns, options.photos, [](const CheckedPhoto&, const std::string&) {}, progress);
  CheckAnyUsable(checked, options.photos);
  Observations observations = ObservePhotos(checked, options.photos, progress);
  for (PhotoCamera& camera : observations.cameras) camera.focal_px = options.focal_px;
  ListDoubts(checked, solved);
  std::set<std::string> names;
  for (const PanelPhoto& photo : observations.photos) names.insert(photo.photo);
  solved.photos = HashPhotos(names, options.photos);
  progress.Start("solution", 1, "calibration");
  CalibrateOptions calibrate;
  calibrate.eye_box = EyesOf(solved.display);
  solved.report = Calibrate(observations, design, calibrate);
  solved.left_out.insert(solved.left_out.end(), solved.report.rejected.begin(),
                         solved.report.rejected.end());
  progress.Advance();
  return solved;
}

}  // namespace lamella
