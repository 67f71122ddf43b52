#include "pipeline/observe_photos.h"

#include <algorithm>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "calibration/phase.h"
#include "lightfield/error.h"

namespace lamella {
namespace fs = std::filesystem;
namespace {

using Kind = PatternShot::Kind;

const CheckedPhoto* Find(const CheckedPhotos& checked, int view, Kind kind,
                         const std::optional<PanelId>& panel, const Pattern& pattern) {
  for (const CheckedPhoto& photo : checked.photos) {
    if (!photo.good || !photo.shot || photo.view != view) continue;
    const PatternShot& shot = checked.list.shots[*photo.shot];
    if (shot.kind != kind || shot.again || !(shot.pattern == pattern)) continue;
    if (!panel || shot.panel == *panel) return &photo;
  }
  return nullptr;
}

// The photographs of a panel's sinusoids, series by series, then white and black; nothing where one
// is absent.
std::optional<std::vector<const CheckedPhoto*>> PhasePhotosOf(const CheckedPhotos& checked,
                                                              int view,
                                                              const CalibratedPanel& panel,
                                                              const std::vector<PhaseSeries>& all) {
  std::vector<const CheckedPhoto*> photos;
  for (const PhaseSeries& series : all) {
    for (int step = 0; step < series.steps; ++step) {
      photos.push_back(
          Find(checked, view, Kind::kPhase, panel.id, {Pattern::Kind::kPhase, series, step}));
    }
  }
  const PanelId layer{panel.id.layer, PanelId::kEmitter};
  photos.push_back(Find(checked, view, Kind::kWhite, layer, {}));
  photos.push_back(panel.id.role == PanelId::kModulator
                       ? Find(checked, view, Kind::kLeak, layer, {})
                       : Find(checked, view, Kind::kDark, std::nullopt, {}));
  if (std::count(photos.begin(), photos.end(), nullptr) > 0) return std::nullopt;
  return photos;
}

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
  const auto all = PhaseSeriesOf(panel.size.width_px, panel.size.height_px);
  const auto photos = PhasePhotosOf(checked, view, panel, all);
  if (!photos) return std::nullopt;
  std::vector<Image<float>> images;
  for (const CheckedPhoto* photo : *photos) images.push_back(ReadLuminance(folder / photo->photo));
  PhaseCapture capture;
  auto image = images.begin();
  for (const PhaseSeries& series : all) {
    PhasePhotos group{series, {}};
    for (int step = 0; step < series.steps; ++step) group.photos.push_back((image++)->span());
    capture.series.push_back(std::move(group));
  }
  capture.white = (image++)->span();
  capture.black = image->span();
  capture.width_px = panel.size.width_px;
  capture.height_px = panel.size.height_px;
  capture.through_lenses = checked.list.planes_in_turn;
  return DecodedPanel{DecodePhase(capture), photos->front()->photo};
}

void CheckOneSize(const CheckedPhotos& checked) {
  const CheckedPhoto* first = nullptr;
  for (const CheckedPhoto& photo : checked.photos) {
    if (!photo.good) continue;
    if (first == nullptr) first = &photo;
    if (photo.facts.width == first->facts.width && photo.facts.height == first->facts.height) {
      continue;
    }
    throw InputError(
        photo.photo,
        fmt::format("is {} x {} px, {} is {} x {}", photo.facts.width, photo.facts.height,
                    first->photo, first->facts.width, first->facts.height),
        "take all with one camera, unturned and uncropped");
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
          {panel.id, view, 0, seen->photo,
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
