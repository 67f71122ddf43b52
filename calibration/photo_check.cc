#include "calibration/photo_check.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <map>
#include <numeric>

#include <Eigen/Cholesky>
#include <fmt/format.h>

#include "lightfield/color.h"

namespace lamella {
namespace {

using Eigen::Vector2d;
using Kind = PatternShot::Kind;

// calibration.md sections 3, 4 and 7.
constexpr double kLeastSquarePx = 48, kLeastShareOfCorners = 0.6, kMostBlurPx = 2;
constexpr std::size_t kLeastUsableCorners = 8;
constexpr double kMostSaturated = 0.002;
constexpr float kFullScale = 0.995F;
constexpr double kDark = 0.12;      // brighter is no dark photograph; 1.3 % of the light in sRGB
constexpr double kMostLeak = 0.35;  // through a closed modulator; a tenth of the light
constexpr double kLeastStep = 0.16;
// A printed board between sinusoids: seen in no more of them, and as well as where it is due.
constexpr double kMostUndue = 0.2, kAsWell = 2;
constexpr double kMostRetakePx = 3;  // a camera that is touched for a retake; no other position

const CalibratedPanel& PanelOf(const ShotList& list, const PanelId& id) {
  return *std::find_if(list.panels.begin(), list.panels.end(),
                       [&](const CalibratedPanel& panel) { return panel.id == id; });
}

bool IsDark(const PatternShot& shot) {
  return shot.kind == Kind::kDark || shot.kind == Kind::kLeak;
}

struct Advice {
  bool good = true;
  std::string text;
};

Advice JudgeExposure(const PhotoFacts& facts) {
  if (facts.saturated > kMostSaturated) {
    return {false, fmt::format("{:.1f} % of it is overexposed: expose less, all shots alike",
                               100 * facts.saturated)};
  }
  if (facts.bright - facts.dark < kLeastStep) {
    return {false, fmt::format("black and white differ by {:.0f} % of full scale only: expose "
                               "longer, all shots alike",
                               100 * (facts.bright - facts.dark))};
  }
  return {};
}

Advice JudgeDark(const PhotoFacts& facts, Kind kind) {
  const double most = kind == Kind::kLeak ? kMostLeak : kDark;
  const std::string level = fmt::format("up to {:.0f} % of full scale", 100 * facts.bright);
  if (facts.bright < most) return {true, level};
  return {false, level + (kind == Kind::kLeak ? ": close the modulator (black), its emitter white"
                                              : ": darken the room, and show black everywhere")};
}

Advice JudgeBoard(const BoardSighting& seen, const CharucoBoard& board, bool mirrored) {
  const auto found = static_cast<int>(seen.points.size());
  const double square_px = seen.scale * board.square_px;
  const std::string corners = fmt::format("{} of {} corners", found, board.num_corners());
  if (seen.mirrored != mirrored) {
    return {false, fmt::format("the panel is seen {}, the display's mirror_x says otherwise: mend "
                               "the display's file, or show the pattern unflipped",
                               seen.mirrored ? "in a mirror" : "directly")};
  }
  if (seen.blur_px > kMostBlurPx) {
    return {false, fmt::format("{}, edges blurred by {:.1f} px: focus nearer to the panel", corners,
                               seen.blur_px)};
  }
  if (square_px < kLeastSquarePx) {
    return {false, fmt::format("{}, squares of {:.0f} px only: go nearer or zoom in until they "
                               "have {:.0f}",
                               corners, square_px, kLeastSquarePx)};
  }
  if (found < kLeastShareOfCorners * board.num_corners()) {
    return {false, fmt::format("{} only: bring the whole board into the picture, unreflected and "
                               "uncovered",
                               corners)};
  }
  return {true, fmt::format("{}, blur {:.1f} px, {:.2f} px per panel px", corners, seen.blur_px,
                            seen.scale)};
}

constexpr const char* kNoBoard =
    "no board is seen: show this shot's images only, the whole panel in the picture and in focus";
constexpr const char* kNoPrintedBoard =
    "the printed board is not seen: light it, the whole of it in the picture and in focus";
constexpr const char* kMirroredPrintedBoard =
    "the printed board is seen in a mirror: photograph it directly, and leave the picture "
    "unflipped";

Advice JudgeSighting(const PhotoFacts& facts, const ShotList& list, const PatternShot& shot) {
  if (shot.kind == Kind::kPrinted) {
    if (!facts.printed) return {false, kNoPrintedBoard};
    if (facts.sighting->mirrored) return {false, kMirroredPrintedBoard};
    return JudgeBoard(*facts.sighting, list.printed->board, false);
  }
  const CalibratedPanel& panel = PanelOf(list, shot.panel);
  return facts.sighting ? JudgeBoard(*facts.sighting, *panel.board, panel.mirrored)
                        : Advice{false, kNoBoard};
}

// Corners state how well they are known, so that small or soft ones do no harm.
bool IsUsable(const PhotoFacts& facts, const ShotList& list, const PatternShot& shot) {
  const bool mirrored = shot.kind == Kind::kBoard && PanelOf(list, shot.panel).mirrored;
  return facts.sighting && facts.saturated <= kMostSaturated &&
         facts.sighting->mirrored == mirrored &&
         facts.sighting->points.size() >= kLeastUsableCorners;
}

// RMS of what the corners state.
double CornerSd(const BoardSighting& seen) {
  double variance = 0;
  for (const Observation& point : seen.points) variance += point.covariance_px2.trace() / 2;
  return std::sqrt(variance / static_cast<double>(std::max<std::size_t>(1, seen.points.size())));
}

// The displacements' affine field over the panel, so that the corners' noise averages out: its
// median length at the corners. None where no corner is seen in both.
std::optional<double> MedianMotion(const std::vector<Observation>& before,
                                   const std::vector<Observation>& after) {
  std::map<std::pair<double, double>, Vector2d> places;
  for (const Observation& point : before) {
    places[{point.panel_px.x(), point.panel_px.y()}] = point.image_px;
  }
  std::vector<std::pair<Vector2d, Vector2d>> moved;  // place, displacement
  Vector2d mean(0, 0);
  for (const Observation& point : after) {
    const auto place = places.find({point.panel_px.x(), point.panel_px.y()});
    if (place == places.end()) continue;
    moved.emplace_back(place->second, point.image_px - place->second);
    mean += place->second;
  }
  if (moved.empty()) return std::nullopt;
  mean /= static_cast<double>(moved.size());
  Eigen::Matrix3d information = 1e-6 * Eigen::Matrix3d::Identity();
  Eigen::Matrix<double, 3, 2> right = Eigen::Matrix<double, 3, 2>::Zero();
  for (const auto& [place, displacement] : moved) {
    const Eigen::Vector3d row = (place - mean).homogeneous();
    information += row * row.transpose();
    right += row * displacement.transpose();
  }
  const Eigen::Matrix<double, 3, 2> field = information.ldlt().solve(right);
  std::vector<double> lengths;
  for (const auto& [place, displacement] : moved) {
    lengths.push_back((field.transpose() * (place - mean).homogeneous()).norm());
  }
  const auto middle = lengths.begin() + static_cast<std::ptrdiff_t>(lengths.size() / 2);
  std::nth_element(lengths.begin(), middle, lengths.end());
  return *middle;
}

// Means over blocks, in which the noise of single pixels is no light. What blocks do not divide is
// left out.
std::vector<float> BlockMeans(ImageSpan<const float> light) {
  const int block = std::clamp(std::min(light.width, light.height), 1, 4);
  std::vector<float> means;
  for (int y = 0; y + block <= light.height; y += block) {
    for (int x = 0; x + block <= light.width; x += block) {
      float sum = 0;
      for (int j = 0; j < block; ++j) {
        sum = std::accumulate(light.row(y + j) + x, light.row(y + j) + x + block, sum);
      }
      means.push_back(sum / static_cast<float>(block * block));
    }
  }
  return means;
}

double ShareAtFullScale(ImageSpan<const float> light) {
  const float full_scale = SrgbToLinear(kFullScale);
  std::int64_t count = 0;
  for (int y = 0; y < light.height; ++y) {
    count += std::count_if(light.row(y), light.row(y) + light.width,
                           [=](float value) { return value >= full_scale; });
  }
  return static_cast<double>(count) / light.width / light.height;
}

}  // namespace

PhotoFacts ExaminePhoto(ImageSpan<const float> light, const ShotList& list) {
  PhotoFacts facts;
  facts.width = light.width;
  facts.height = light.height;
  std::vector<float> values = BlockMeans(light);
  const auto percentile = [&](double share) {
    const auto at = values.begin() +
                    static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1));
    std::nth_element(values.begin(), at, values.end());
    return static_cast<double>(LinearToSrgb(*at));
  };
  facts.dark = percentile(0.01);
  facts.bright = percentile(0.99);
  facts.saturated = ShareAtFullScale(light);
  std::vector<CharucoBoard> boards;
  std::vector<PanelId> panels;
  for (const CalibratedPanel& panel : list.panels) {
    if (!panel.board) continue;
    boards.push_back(*panel.board);
    panels.push_back(panel.id);
  }
  if (list.printed) boards.push_back(list.printed->board);
  facts.sighting = DetectBoard(light, boards);
  if (!facts.sighting) return facts;
  facts.printed = facts.sighting->board == panels.size();
  if (!facts.printed) facts.panel = panels[facts.sighting->board];
  return facts;
}

bool PhotoCheck::Shows(const PhotoFacts& facts, std::size_t index) const {
  const PatternShot& shot = list_.shots[index];
  if (shot.kind == Kind::kBoard) return facts.panel == shot.panel;
  if (shot.kind == Kind::kPrinted) return facts.printed;
  if (facts.panel || facts.printed) return false;
  if (shot.kind == Kind::kLeak) return facts.bright < kMostLeak;
  return IsDark(shot) == (facts.bright < kDark);
}

PhotoCheck::Place PhotoCheck::PlaceOf(const PhotoFacts& facts) const {
  const std::size_t count = list_.shots.size();
  if (next_ < count && Shows(facts, next_)) return {next_, false};
  if (facts.printed) {
    for (std::size_t i = 0; i < count; ++i) {
      if (Shows(facts, i)) return {i, IsFromElsewhere(facts, i)};
    }
  }
  if (facts.panel) {
    // A retake, rather than a repeat with shots left out before it.
    std::optional<std::size_t> first;
    for (std::size_t i = 0; i < count && !first; ++i) {
      if (Shows(facts, i)) first = i;
    }
    return {first, first && next_ == count && *first < next_ && Taken(view_, *first) &&
                       Taken(view_, *first)->good};
  }
  const bool is_dark = facts.bright < kDark;
  if (is_dark && next_ > 0) return {0, true};
  // Whatever should have been a board and is none.
  const bool is_board_due = next_ < count && (list_.shots[next_].kind == Kind::kBoard ||
                                              list_.shots[next_].kind == Kind::kPrinted);
  if (!is_dark && is_board_due) return {next_, false};
  return {};
}

bool PhotoCheck::MayBePrinted(const PhotoFacts& facts) const {
  if (facts.bright < kDark) return false;
  return next_ <= 1 || next_ == list_.shots.size() || list_.shots[next_].kind == Kind::kPrinted;
}

bool PhotoCheck::IsFromElsewhere(const PhotoFacts& facts, std::size_t shot) const {
  const CheckedPhoto* before = Taken(view_, shot);
  if (before == nullptr || !before->usable) return false;
  const auto motion = MedianMotion(before->facts.sighting->points, facts.sighting->points);
  return !motion || *motion > kMostRetakePx;
}

const CheckedPhoto* PhotoCheck::Taken(int view, std::size_t shot) const {
  for (const CheckedPhoto& photo : photos_) {
    if (photo.view == view && photo.shot == shot) return &photo;
  }
  return nullptr;
}

std::optional<double> PhotoCheck::Motion(const CheckedPhoto& again) const {
  const PatternShot& shot = list_.shots[*again.shot];
  for (std::size_t i = 0; i < *again.shot; ++i) {
    const PatternShot& other = list_.shots[i];
    if (other.kind != shot.kind || other.panel != shot.panel || !(other.pattern == shot.pattern)) {
      continue;
    }
    const CheckedPhoto* before = Taken(again.view, i);
    if (before == nullptr || !before->facts.sighting || !again.facts.sighting) return std::nullopt;
    return MedianMotion(before->facts.sighting->points, again.facts.sighting->points);
  }
  return std::nullopt;
}

void PhotoCheck::Judge(CheckedPhoto& photo) const {
  if (!photo.shot) {
    const std::string expected =
        next_ < list_.shots.size() ? list_.shots[next_].name : list_.shots[0].name;
    photo.verdict = fmt::format("no shot of the list; {} was expected: take that", expected);
    return;
  }
  const PatternShot& shot = list_.shots[*photo.shot];
  Advice advice;
  if (IsDark(shot)) {
    advice = JudgeDark(photo.facts, shot.kind);
  } else {
    advice = JudgeExposure(photo.facts);
    if (advice.good && (shot.kind == Kind::kBoard || shot.kind == Kind::kPrinted)) {
      advice = JudgeSighting(photo.facts, list_, shot);
    }
    if (shot.again) photo.moved_px = Motion(photo);
    if (advice.good && shot.again) {
      if (const auto motion = photo.moved_px) {
        const bool still = *motion <= kMostMotionPx;
        advice = {still, fmt::format("moved by {:.3f} px since the first{}", *motion,
                                     still ? "" : ": fix the camera, and take this position anew")};
      }
    }
  }
  photo.good = advice.good;
  const bool has_board = shot.kind == Kind::kBoard || shot.kind == Kind::kPrinted;
  photo.usable = has_board && !shot.again && (advice.good || IsUsable(photo.facts, list_, shot));
  photo.verdict = (advice.good ? "good" : "take again") +
                  (advice.text.empty() ? std::string() : ": " + advice.text);
}

const CheckedPhoto& PhotoCheck::Add(const std::string& photo, PhotoFacts facts) {
  double undue_board_sd_px = 0;
  if (facts.printed && !MayBePrinted(facts)) {
    undue_board_sd_px = CornerSd(*facts.sighting);
    facts.printed = false;
    facts.sighting.reset();
  }
  const Place place = PlaceOf(facts);
  if (place.new_view) {
    ++view_;
    next_ = 0;
  }
  CheckedPhoto checked{photo, view_, place.shot, false, false, "", std::nullopt, std::move(facts)};
  checked.undue_board_sd_px = undue_board_sd_px;
  Judge(checked);
  if (place.shot) {
    next_ = std::max(next_, *place.shot + 1);
    std::erase_if(photos_, [&](const CheckedPhoto& old) {
      return old.view == view_ && old.shot == place.shot;
    });
  }
  photos_.push_back(std::move(checked));
  return photos_.back();
}

bool IsOfBoardAlone(const ShotList& list, const std::vector<CheckedPhoto>& photos, int view) {
  bool has_board = false;
  for (const CheckedPhoto& photo : photos) {
    if (photo.view != view) continue;
    if (!photo.shot) return false;
    const Kind kind = list.shots[*photo.shot].kind;
    if (kind != Kind::kPrinted && kind != Kind::kDark) return false;
    has_board = has_board || (kind == Kind::kPrinted && photo.usable);
  }
  return has_board;
}

std::optional<std::string> BoardInBetween(const ShotList& list,
                                          const std::vector<CheckedPhoto>& photos, int view) {
  double due_sd_px = 0;
  int num_phase = 0, num_undue = 0;
  const CheckedPhoto* first = nullptr;
  for (const CheckedPhoto& photo : photos) {
    if (photo.view != view || !photo.shot) continue;
    const Kind kind = list.shots[*photo.shot].kind;
    if (kind == Kind::kPrinted && photo.usable) due_sd_px = CornerSd(*photo.facts.sighting);
    if (kind != Kind::kPhase) continue;
    ++num_phase;
    if (photo.undue_board_sd_px == 0) continue;
    ++num_undue;
    if (first == nullptr || photo.undue_board_sd_px < first->undue_board_sd_px) first = &photo;
  }
  if (first == nullptr || kMostUndue * num_phase < num_undue) return std::nullopt;
  if (first->undue_board_sd_px > kAsWell * due_sd_px) return std::nullopt;
  return first->photo;
}

bool MayBeOfBoardAlone(const ShotList& list, const std::vector<CheckedPhoto>& photos, int view) {
  if (!list.printed) return false;
  std::size_t taken = 0;
  for (const CheckedPhoto& photo : photos) {
    if (photo.view != view || !photo.shot) continue;
    if (list.shots[*photo.shot].kind == Kind::kPrinted) return false;
    ++taken;
  }
  return 2 * taken < list.shots.size();
}

std::vector<std::string> PhotoCheck::Missing() const {
  std::vector<std::string> lines;
  for (int view = 0; view <= view_; ++view) {
    if (IsOfBoardAlone(list_, photos_, view)) continue;
    std::string names;
    std::size_t count = 0;
    constexpr std::size_t kMostNamed = 4;
    for (std::size_t shot = 0; shot < list_.shots.size(); ++shot) {
      const CheckedPhoto* taken = Taken(view, shot);
      if (taken != nullptr && taken->good) continue;
      if (++count <= kMostNamed) names += (count > 1 ? ", " : "") + list_.shots[shot].name;
    }
    if (count > kMostNamed) names += fmt::format(" and {} more", count - kMostNamed);
    if (const auto board = BoardInBetween(list_, photos_, view)) {
      lines.push_back(fmt::format("position {}: {} {}", view + 1, *board, kLeaveBoardOut));
    }
    if (count == 0) continue;
    if (MayBeOfBoardAlone(list_, photos_, view)) names += fmt::format("; {}", kBoardAloneNotFound);
    lines.push_back(fmt::format("position {}: take {}", view + 1, names));
  }
  return lines;
}

Observations ObservationsOf(const ShotList& list, const std::vector<CheckedPhoto>& photos) {
  Observations observations;
  for (const CheckedPhoto& photo : photos) {
    if (!photo.usable || list.shots[*photo.shot].kind != Kind::kBoard) continue;
    if (observations.cameras.empty()) {
      observations.cameras.push_back({"body", photo.facts.width, photo.facts.height, 0});
    }
    observations.photos.push_back(
        {list.shots[*photo.shot].panel, photo.view, 0, photo.photo, photo.facts.sighting->points});
  }
  return observations;
}

}  // namespace lamella
