// What a display shows in front of a camera: a workspace's frames, or a file of shots.
#pragma once

#include <filesystem>
#include <map>
#include <memory>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "datasets_synthetic/prototype.h"
#include "lightfield/calibration.h"

namespace lamella {

// A picture of every layer while the shutter is open; loaded some at a time, since they are large.
struct Shot {
  struct LayerFiles {
    // Time slots, as many of both: a file, "white" or "black".
    std::vector<std::string> emitter, modulator;
    std::vector<int> order{};  // in which they are shown; as listed where empty
  };
  std::string name;
  std::vector<LayerFiles> layers;
  double exposure = 1;            // times that of the others
  std::filesystem::path printed;  // picture of a lit board beside the display; empty: none
  double printed_width_mm = 0;    // of the picture
  int cameras = 0;  // photographed from so many of them only, from the first on; 0: from all
};

// The frames of W/frames/frames.json as one shot, named "frames". The planes of a varifocal display
// are layers that light up one after the other; InputError where they are packed one-bit frames.
Shot ShotOfFrames(const std::filesystem::path& folder);
// The panels' curve that the frames were encoded for.
ToneCurve CurveOfFrames(const std::filesystem::path& folder);
// docs/formats.md, "shots"; files are relative to it.
std::vector<Shot> ReadShots(const std::filesystem::path& file);

// The images that a shot shows on the calibration's panels, each once.
std::set<std::filesystem::path> FilesOf(const Shot& shot, const Calibration& calibration);

// Loads one shot after the other: panels that show what they show in a shot that is still in memory
// share its images.
class ShotLoader {
 public:
  // Refers to the calibration; `slot_crosstalk` is a display's.
  explicit ShotLoader(const Calibration& calibration, double slot_crosstalk = 0);
  // InputError where the shot has not the calibration's layers or an image not its panel's size.
  std::vector<ShownLayer> Load(const Shot& shot);

 private:
  template <class T>
  using Loaded = std::map<std::pair<std::size_t, std::string>, std::weak_ptr<const Image<T>>>;
  const Calibration& calibration_;
  double slot_crosstalk_;
  Loaded<Rgb> emitters_;  // by layer and source
  Loaded<float> modulators_;
};

// The light of the brightest layer, on average over its face, were all its emitters white: gain *
// mean transmittance. A scene's white is what one layer shows while the others are black.
double WhiteOf(const Calibration& calibration, const std::vector<ShownLayer>& shown);

}  // namespace lamella
