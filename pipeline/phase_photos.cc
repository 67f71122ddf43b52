#include "pipeline/phase_photos.h"

#include <algorithm>
#include <utility>

#include "pipeline/errors_of_each.h"

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

}  // namespace

std::optional<PhasePhotoSet> ReadPhasePhotos(
    const CheckedPhotos& checked, const fs::path& folder, int view, const CalibratedPanel& panel,
    const std::function<Image<float>(const fs::path&)>& read) {
  const auto all = PhaseSeriesOf(panel.size.width_px, panel.size.height_px);
  const auto photos = PhasePhotosOf(checked, view, panel, all);
  if (!photos) return std::nullopt;
  PhasePhotoSet set;
  for (const CheckedPhoto* photo : *photos) set.names.push_back(photo->photo);
  set.images.resize(set.names.size());
  ThrowFirst(ErrorsOfEach(set.names.size(),
                          [&](std::size_t i) { set.images[i] = read(folder / set.names[i]); }));
  auto image = set.images.begin();
  for (const PhaseSeries& series : all) {
    PhasePhotos group{series, {}};
    for (int step = 0; step < series.steps; ++step) group.photos.push_back((image++)->span());
    set.capture.series.push_back(std::move(group));
  }
  set.capture.white = (image++)->span();
  set.capture.black = image->span();
  set.capture.width_px = panel.size.width_px;
  set.capture.height_px = panel.size.height_px;
  return set;
}

}  // namespace lamella
