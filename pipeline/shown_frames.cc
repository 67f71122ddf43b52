#include "pipeline/shown_frames.h"

#include <algorithm>
#include <map>
#include <memory>

#include <fmt/format.h>

#include "distribute/encode_barrier.h"
#include "lightfield/error.h"
#include "lightfield/image_io.h"
#include "pipeline/json_file.h"

namespace lamella {
namespace fs = std::filesystem;
namespace {

constexpr int kShownVersion = 1;
constexpr const char *kWhite = "white", *kBlack = "black";

Image<Rgb8> CodesOf(const std::string& source, const PanelCalibration& panel) {
  if (source == kWhite) return {panel.width_px, panel.height_px, Rgb8{255, 255, 255}};
  if (source == kBlack) return {panel.width_px, panel.height_px, Rgb8{}};
  Image<Rgb8> codes = ReadSrgb8(source);
  if (codes.width() != panel.width_px || codes.height() != panel.height_px) {
    throw InputError(source,
                     fmt::format("is {} x {} px, the panel {} x {}", codes.width(), codes.height(),
                                 panel.width_px, panel.height_px),
                     "give an image of the panel's pixels");
  }
  return codes;
}

// One image per slot of a layer's panel. What is in memory is not made again.
template <class T, class Loaded, class Make>
std::vector<std::shared_ptr<const Image<T>>> LoadImages(const std::vector<std::string>& sources,
                                                        std::size_t layer,
                                                        const PanelCalibration& panel,
                                                        Loaded& loaded, Make make) {
  std::vector<std::shared_ptr<const Image<T>>> images;
  for (const std::string& source : sources) {
    std::weak_ptr<const Image<T>>& known = loaded[{layer, source}];
    std::shared_ptr<const Image<T>> image = known.lock();
    if (!image) {
      image = std::make_shared<const Image<T>>(make(panel, CodesOf(source, panel).span()));
      known = image;
    }
    images.push_back(std::move(image));
  }
  return images;
}

std::vector<std::string> Sources(const JsonObject& json, const char* key, const char* otherwise) {
  if (!json.Has(key)) return {otherwise};
  std::vector<std::string> sources = json.Texts(key);
  if (sources.empty()) throw json.Wrong(key, "a list of one or more images");
  const fs::path folder = fs::path(json.where().substr(0, json.where().find(": "))).parent_path();
  for (std::string& source : sources) {
    if (source != kWhite && source != kBlack) source = (folder / source).string();
  }
  return sources;
}

Shot::LayerFiles ReadLayer(const JsonObject& json) {
  json.CheckKeys({"emitter", "modulator"});
  Shot::LayerFiles files{Sources(json, "emitter", kBlack), Sources(json, "modulator", kWhite)};
  const std::size_t slots = std::max(files.emitter.size(), files.modulator.size());
  for (auto* sources : {&files.emitter, &files.modulator}) {
    if (sources->size() == 1) sources->resize(slots, sources->front());
    if (sources->size() != slots) {
      throw InputError(json.where(), "emitter and modulator have different numbers of time slots",
                       "give one image or as many");
    }
  }
  return files;
}

JsonObject FramesJson(const fs::path& folder) {
  JsonObject json(folder / "frames.json");
  json.CheckFormatVersion(kShownVersion);
  return json;
}

}  // namespace

Shot ShotOfFrames(const fs::path& folder) {
  Shot shot;
  shot.name = "frames";
  if (FramesJson(folder).Has("strokes")) {
    throw InputError((folder / "frames.json").string(),
                     "has packed one-bit planes, which only a moving mirror sorts by depth",
                     "make frames that stand still: lamella frames --planes grey");
  }
  for (const JsonObject& layer : FramesJson(folder).Objects("layers")) {
    const int k = layer.Whole("slots_per_axis", 1, 32);
    Shot::LayerFiles files;
    files.emitter.resize(static_cast<std::size_t>(k) * static_cast<std::size_t>(k));
    files.modulator.resize(files.emitter.size(), kWhite);  // lenses have none
    files.order = SlotOrder(k);
    for (const JsonObject& frame : layer.Objects("frames")) {
      const auto slot = static_cast<std::size_t>(frame.Whole("slot", 0, k * k - 1));
      const bool emits = frame.Text("role") == "emitter";
      (emits ? files.emitter : files.modulator)[slot] = (folder / frame.Text("file")).string();
    }
    shot.layers.push_back(std::move(files));
  }
  return shot;
}

ToneCurve CurveOfFrames(const fs::path& folder) {
  const JsonObject response = FramesJson(folder).Object("response");
  ToneCurve curve;
  if (response.Text("curve") == "gamma") {
    curve.kind = ToneCurve::Kind::kGamma;
    curve.gamma = response.Number("gamma");
  }
  return curve;
}

std::vector<Shot> ReadShots(const fs::path& file) {
  const JsonObject json(file);
  json.CheckFormatVersion(kShownVersion);
  json.CheckKeys({"format_version", "shots"});
  std::vector<Shot> shots;
  for (const JsonObject& object : json.Objects("shots")) {
    object.CheckKeys({"name", "layers", "exposure", "cameras", "printed"});
    Shot shot;
    shot.name = object.Text("name");
    if (shot.name.empty() || shot.name.find('/') != std::string::npos) {
      throw object.Wrong("name", "a part of a file's name");
    }
    shot.exposure = object.NumberOr("exposure", 1);
    if (!(shot.exposure > 0)) throw object.Wrong("exposure", "a factor above 0");
    if (object.Has("cameras")) shot.cameras = object.Whole("cameras", 1, 1 << 20);
    if (object.Has("printed")) {
      const JsonObject printed = object.Object("printed");
      printed.CheckKeys({"file", "width_mm"});
      shot.printed = file.parent_path() / printed.Text("file");
      shot.printed_width_mm = printed.Number("width_mm");
      if (!(shot.printed_width_mm > 0)) throw printed.Wrong("width_mm", "millimetres above 0");
    }
    for (const JsonObject& layer : object.Objects("layers"))
      shot.layers.push_back(ReadLayer(layer));
    shots.push_back(std::move(shot));
  }
  if (shots.empty()) throw json.Wrong("shots", "one or more");
  return shots;
}

std::set<fs::path> FilesOf(const Shot& shot, const Calibration& calibration) {
  std::set<fs::path> files;
  if (!shot.printed.empty()) files.insert(shot.printed);
  for (std::size_t l = 0; l < std::min(shot.layers.size(), calibration.layers.size()); ++l) {
    const Shot::LayerFiles& layer = shot.layers[l];
    files.insert(layer.emitter.begin(), layer.emitter.end());
    if (calibration.layers[l].modulator) {
      files.insert(layer.modulator.begin(), layer.modulator.end());
    }
  }
  files.erase(kWhite);
  files.erase(kBlack);
  return files;
}

ShotLoader::ShotLoader(const Calibration& calibration, double slot_crosstalk)
    : calibration_(calibration), slot_crosstalk_(slot_crosstalk) {}

std::vector<ShownLayer> ShotLoader::Load(const Shot& shot) {
  if (shot.layers.size() != calibration_.layers.size()) {
    throw InputError(fmt::format("shot \"{}\"", shot.name),
                     fmt::format("is of {} layers, the display has {}", shot.layers.size(),
                                 calibration_.layers.size()),
                     "show every layer, black ones too");
  }
  std::vector<ShownLayer> shown;
  for (std::size_t l = 0; l < shot.layers.size(); ++l) {
    const LayerCalibration& layer = calibration_.layers[l];
    ShownLayer images;
    images.emitter =
        LoadImages<Rgb>(shot.layers[l].emitter, l, layer.emitter, emitters_, LightOfEmitter);
    if (layer.modulator) {
      images.modulator = LoadImages<float>(shot.layers[l].modulator, l, *layer.modulator,
                                           modulators_, TransmittanceOfModulator);
    }
    const std::size_t slots = images.emitter.size();
    if (slot_crosstalk_ > 0 && slots > 1) {
      std::vector<int> order = shot.layers[l].order;
      for (std::size_t t = order.size(); t < slots; ++t) order.push_back(static_cast<int>(t));
      images = WithSlotCrosstalk(images, order, slot_crosstalk_);
    }
    shown.push_back(std::move(images));
  }
  return shown;
}

double WhiteOf(const Calibration& calibration, const std::vector<ShownLayer>& shown) {
  double white = 0;
  for (std::size_t l = 0; l < shown.size(); ++l) {
    double sum = 0, count = 0;
    for (const auto& image : shown[l].modulator) {
      for (std::size_t i = 0; i < image->size(); ++i) sum += static_cast<double>(image->data()[i]);
      count += static_cast<double>(image->size());
    }
    white = std::max(white, calibration.layers[l].gain * (count > 0 ? sum / count : 1.0));
  }
  return white;
}

}  // namespace lamella
