// Photographs of a calibration, judged one by one as they are taken: which shot of the list each
// is, whether it will do, and what to do if not.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "calibration/detect_board.h"
#include "calibration/observations.h"
#include "calibration/shot_list.h"
#include "lightfield/image.h"

namespace lamella {

// What a photograph shows, whatever it is of. Levels are sRGB's of its light, 0 to 1.
struct PhotoFacts {
  int width = 0, height = 0;
  double dark = 0, bright = 0;   // 1st and 99th percentile of means over 4 x 4 px
  double saturated = 0;          // share of pixels at full scale
  std::optional<PanelId> panel;  // whose board is seen
  std::optional<BoardSighting> sighting;
  bool printed = false;  // it is the printed board's
};
// `light` is linear, 1 full scale.
PhotoFacts ExaminePhoto(ImageSpan<const float> light, const ShotList& list);

// A camera that moved more at a position makes its photographs worthless together (calibration.md
// section 3).
inline constexpr double kMostMotionPx = 0.05;

struct CheckedPhoto {
  std::string photo;
  int view = 0;                     // camera position, from 0
  std::optional<std::size_t> shot;  // in the list; none where it is no shot of it
  bool good = false;
  bool usable = false;  // a board whose corners are worth using, if not as good as they could be
  std::string verdict;  // one line: what it is, and what to do
  std::optional<double> moved_px;  // of a repeated shot: the camera's motion since the first
  PhotoFacts facts;
  // How well corners of a printed board state to be known that is seen though it is not due: 0
  // where none is.
  double undue_board_sd_px = 0;
};

// The photograph of a position that shows the printed board between sinusoids, where it counts as
// the one that is due and makes others of those after it. A board that is faintly seen beside the
// display is in many of them, or less well than in its own photograph. None where that is not
// there.
std::optional<std::string> BoardInBetween(const ShotList& list,
                                          const std::vector<CheckedPhoto>& photos, int view);
inline constexpr const char* kLeaveBoardOut =
    "shows the printed board between sinusoids, where it counts as one of them: leave it out";

// Whether the printed board, well, and dark shots are all that was photographed from a position:
// which calibrates the camera.
bool IsOfBoardAlone(const ShotList& list, const std::vector<CheckedPhoto>& photos, int view);

// Whether so little of the list was photographed from a position, and no printed board, that it may
// be one of the board alone in which the board was not found: dark, then a blurred board, looks
// like dark and white.
bool MayBeOfBoardAlone(const ShotList& list, const std::vector<CheckedPhoto>& photos, int view);
inline constexpr const char* kBoardAloneNotFound =
    "where it is of the printed board alone, the board was not found: photograph it again, lit, "
    "the whole of it in the picture and in focus";

// Takes the photographs in the order in which they were taken: at every camera position all shots
// of the list, a failed one again at any time before the position changes. Boards tell their panel,
// or that they are the printed one; dark and white photographs and sinusoids are told by their
// place between the others. A new position begins with the dark shot, or with the printed board
// where it is seen from elsewhere than before.
class PhotoCheck {
 public:
  explicit PhotoCheck(ShotList list) : list_(std::move(list)) {}

  // The reference is valid until the next call.
  const CheckedPhoto& Add(const std::string& photo, PhotoFacts facts);
  // What is still to be photographed, one line per position; empty where nothing is.
  std::vector<std::string> Missing() const;

  // The last photograph of every shot and position, and those that are no shot.
  const std::vector<CheckedPhoto>& photos() const { return photos_; }
  int num_views() const { return view_ + 1; }

 private:
  struct Place {
    std::optional<std::size_t> shot;
    bool new_view = false;
  };
  Place PlaceOf(const PhotoFacts& facts) const;
  bool Shows(const PhotoFacts& facts, std::size_t index) const;
  // The printed board may be faintly seen beside what any other shot is of: it counts where it is
  // lit and due, after the dark shot alone, or after all shots.
  bool MayBePrinted(const PhotoFacts& facts) const;
  // The printed board, well seen before, from another place: no retake.
  bool IsFromElsewhere(const PhotoFacts& facts, std::size_t shot) const;
  const CheckedPhoto* Taken(int view, std::size_t shot) const;
  void Judge(CheckedPhoto& photo) const;
  // How far the median corner of a repeated shot has moved, px.
  std::optional<double> Motion(const CheckedPhoto& again) const;

  ShotList list_;
  std::vector<CheckedPhoto> photos_;
  int view_ = 0;
  std::size_t next_ = 0;  // the shot that is expected
};

// The usable photographs of boards as calibration reads them, all of one camera; repeats are left
// out.
Observations ObservationsOf(const ShotList& list, const std::vector<CheckedPhoto>& photos);

}  // namespace lamella
