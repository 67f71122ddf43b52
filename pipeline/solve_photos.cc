#include "pipeline/solve_photos.h"

#include <algorithm>
#include <set>
#include <utility>

#include <fmt/format.h>

#include "lightfield/error.h"
#include "lightfield/hash.h"
#include "pipeline/calibration_set_up.h"
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

std::vector<SolvedPhotos::Photo> HashPhotos(const std::set<std::string>& names,
                                            const fs::path& photos) {
  const fs::path folder = fs::is_directory(photos) ? photos : photos.parent_path();
  std::vector<SolvedPhotos::Photo> hashed;
  for (const std::string& name : names) hashed.push_back({name, Sha256OfFile(folder / name)});
  return hashed;
}

SolvedPhotos SolvePhotos(const SolvePhotosOptions& options, Progress& progress) {
  const CalibrationSetUp set_up = LoadCalibrationSetUp(options.patterns, options.display);
  SolvedPhotos solved;
  solved.display = set_up.display;
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
  calibrate.eye_box = CleanEyesOf(solved.display);
  solved.report = Calibrate(observations, set_up.design, calibrate);
  for (const auto* lines : {&solved.report.rejected, &solved.report.at_edges}) {
    solved.left_out.insert(solved.left_out.end(), lines->begin(), lines->end());
  }
  progress.Advance();
  return solved;
}

}  // namespace lamella
