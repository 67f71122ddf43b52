#include "pipeline/observe_photos.h"

#include <algorithm>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "calibration/phase.h"
#include "lightfield/error.h"
#include "pipeline/phase_photos.h"
#include "pipeline/photo_numbers.h"

namespace lamella {
namespace fs = std::filesystem;
namespace {

void LeaveOut(const std::vector<MovedPosition>& moved, const std::string& where,
              Observations& observations) {
  if (moved.empty()) return;
  std::erase_if(observations.photos, [&](const PanelPhoto& photo) {
    return std::any_of(moved.begin(), moved.end(),
                       [&](const MovedPosition& position) { return position.view == photo.view; });
  });
  if (!observations.photos.empty()) return;
  throw InputError(where,
                   fmt::format("the camera moved at every position, by {:.2f} px at the first",
                               moved.front().moved_px),
                   "put it on a tripod, release it remotely, and take the photographs again");
}

}  // namespace

std::optional<DecodedPanel> DecodePanel(const CheckedPhotos& checked, const fs::path& folder,
                                        int view, const CalibratedPanel& panel) {
  auto photos = ReadPhasePhotos(checked, folder, view, panel, ReadLuminance);
  if (!photos) return std::nullopt;
  photos->capture.through_lenses = checked.list.planes_in_turn;
  return DecodedPanel{DecodePhase(photos->capture), photos->names};
}

void CheckOneSize(const CheckedPhotos& checked) {
  const CheckedPhoto* first = nullptr;
  for (const CheckedPhoto& photo : checked.photos) {
    if (!photo.good) continue;
    if (first == nullptr) first = &photo;
    CheckSameSize({photo.photo, photo.facts.width, photo.facts.height},
                  {first->photo, first->facts.width, first->facts.height});
  }
}

std::vector<MovedPosition> MovedPositions(const CheckedPhotos& checked) {
  std::vector<MovedPosition> moved;
  for (const CheckedPhoto& photo : checked.photos) {
    if (photo.moved_px && *photo.moved_px > kMostMotionPx)
      moved.push_back({photo.view, *photo.moved_px});
  }
  return moved;
}

Observations ObservePhotos(const CheckedPhotos& checked, const fs::path& photos,
                           Progress& progress) {
  CheckOneSize(checked);
  const fs::path folder = fs::is_directory(photos) ? photos : photos.parent_path();
  Observations observations = ObservationsOf(checked.list, checked.photos);
  const auto num_panels = static_cast<std::int64_t>(checked.list.panels.size());
  const int num_views = checked.list.mode == CalibrationMode::kPrecise ? checked.num_views : 0;
  if (num_views > 0) progress.Start("sinusoids", num_views * num_panels, "panels");
  for (int view = 0; view < num_views; ++view) {
    for (const CalibratedPanel& panel : checked.list.panels) {
      const auto seen = DecodePanel(checked, folder, view, panel);
      progress.Advance();
      if (!seen) continue;
      std::erase_if(observations.photos, [&](const PanelPhoto& board) {
        return board.view == view && board.panel == panel.id;
      });
      observations.photos.push_back(
          {panel.id, view, 0, seen->photos.front(),
           ObserveNodes(seen->map, NodesOf(panel.size.width_px, panel.size.height_px))});
      if (!observations.cameras.empty()) continue;
      const PhotoFacts& facts = checked.photos.front().facts;
      observations.cameras.push_back({"body", facts.width, facts.height, 0});
    }
  }
  LeaveOut(MovedPositions(checked), photos.string(), observations);
  Check(observations, photos.string());
  return observations;
}

}  // namespace lamella
