#include "pipeline/synth_photos.h"

#include <algorithm>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "datasets_synthetic/sensor.h"
#include "distribute/displays.h"
#include "lightfield/atomic_file.h"
#include "lightfield/error.h"
#include "lightfield/hash.h"
#include "lightfield/image_io.h"
#include "lightfield/parallel.h"
#include "pipeline/calibration_record.h"
#include "pipeline/capture/transforms_json.h"
#include "pipeline/layers_record.h"
#include "pipeline/photo_cameras.h"
#include "pipeline/shown_frames.h"
#include "pipeline/unfinished_photos.h"
#include "pipeline/workspace.h"

namespace lamella {
namespace fs = std::filesystem;
namespace {

using Json = nlohmann::ordered_json;

constexpr int kPhotosVersion = 1;

struct Truth {
  Calibration calibration;
  double slot_crosstalk = 0;  // which a calibration does not say
};

Truth TruthOf(const SynthPhotosOptions& options) {
  if (!options.misalignment.empty()) {
    Truth truth{LoadCalibration(options.misalignment)};
    const Calibration& calibration = truth.calibration;
    if (options.display.empty()) return truth;
    const Display display = FindDisplay(options.display);
    truth.slot_crosstalk = display.slot_crosstalk;
    if (display.name == calibration.display) return truth;
    throw UsageError("--misalignment",
                     fmt::format("is of the display \"{}\", not of \"{}\"", calibration.display,
                                 options.display),
                     "leave --display out, or give a misalignment of that display");
  }
  if (options.display.empty() && options.frames.empty()) {
    throw UsageError("", "it is not said of which display", "give --display or --misalignment");
  }
  LayersRecord shown;
  if (options.display.empty()) {
    shown = LoadLayersRecord(Workspace(fs::absolute(options.frames).parent_path()));
    if (shown.calibration) return {*shown.calibration, shown.display.slot_crosstalk};
  } else {
    shown.display = FindDisplay(options.display);
  }
  Truth truth{DesignCalibration(shown.display), shown.display.slot_crosstalk};
  if (options.frames.empty()) return truth;
  for (LayerCalibration& layer : truth.calibration.layers) {
    layer.emitter.photometry.curve = CurveOfFrames(options.frames);
  }
  return truth;
}

std::vector<Shot> Shots(const SynthPhotosOptions& options) {
  if (options.frames.empty() == options.shots.empty()) {
    throw UsageError("", "it is not said once what the display shows",
                     "give one of --frames and --shots");
  }
  if (!options.shots.empty()) {
    std::vector<Shot> shots = ReadShots(options.shots);
    if (options.printed_board.empty()) {
      std::erase_if(shots, [](const Shot& shot) { return !shot.printed.empty(); });
    }
    return shots;
  }
  return {ShotOfFrames(fs::absolute(options.frames).lexically_normal())};
}

std::string PhotoName(const View& camera, const Shot& shot, std::size_t num_shots) {
  return num_shots > 1 ? fmt::format("{}_{}", camera.name, shot.name) : camera.name;
}

// No photograph may be written over another one.
void CheckNames(const std::vector<Shot>& shots, const std::vector<View>& cameras) {
  std::set<std::string> names;
  for (const Shot& shot : shots) {
    for (const View& camera : cameras) {
      const std::string name = PhotoName(camera, shot, shots.size());
      if (names.insert(name).second) continue;
      throw InputError(name,
                       fmt::format("would be the name of two photographs (the second: camera "
                                   "\"{}\", shot \"{}\")",
                                   camera.name, shot.name),
                       "give every shot and camera a name of its own");
    }
  }
}

Sensor SensorOf(const SynthPhotosOptions& options, double exposure) {
  Sensor sensor{exposure,         options.full_well_e,  options.read_noise_e,
                options.pedestal, Sensor::Curve::kSrgb, options.gamma,
                options.bits};
  if (options.curve == "linear") sensor.curve = Sensor::Curve::kLinear;
  if (options.curve == "gamma") sensor.curve = Sensor::Curve::kGamma;
  if (options.format == "exr") {
    sensor.curve = Sensor::Curve::kLinear;
    sensor.bits = 0;
  }
  return sensor;
}

void WritePhotograph(const fs::path& file, const Image<Rgb>& numbers,
                     const SynthPhotosOptions& options) {
  if (options.format == "exr") {
    std::vector<Channel> channels;
    for (const char* name : {"R", "G", "B"}) {
      channels.push_back({name, {numbers.width(), numbers.height()}});
    }
    for (std::size_t i = 0; i < numbers.size(); ++i) {
      channels[0].pixels.data()[i] = numbers.data()[i].r;
      channels[1].pixels.data()[i] = numbers.data()[i].g;
      channels[2].pixels.data()[i] = numbers.data()[i].b;
    }
    WriteExr(file, channels, ExrType::kFloat);
  } else {
    WriteNumbers(file, numbers.span(), options.bits > 8 ? 16 : 8);
  }
}

// One exposure for all, as of a locked camera; shots may multiply it. Patterns are measured: their
// white stays clear of the sensor's end.
double ExposureOf(const SynthPhotosOptions& options, const std::vector<Shot>& shots,
                  const Calibration& calibration) {
  if (options.exposure) return *options.exposure;
  double white = 0;
  ShotLoader loader(calibration);
  std::vector<ShownLayer> shown;
  for (const Shot& shot : shots) {
    shown = loader.Load(shot);
    white = std::max(white, WhiteOf(calibration, shown));
  }
  const double full_scale = options.shots.empty() ? 1 : 0.8;
  return white > 0 ? full_scale / white : 1;
}

// Paper that is lit so that white comes out as nine tenths of full scale in sRGB.
PrintedSheet SheetOf(const Shot& shot, const Rigid& display_from_sheet, double exposure) {
  constexpr float kWhite = 0.787F;
  const Image<Rgb> picture = ReadImage(shot.printed);
  Image<Rgb> light(picture.width(), picture.height());
  std::transform(picture.data(), picture.data() + picture.size(), light.data(),
                 [=](const Rgb& pixel) { return kWhite / static_cast<float>(exposure) * pixel; });
  return {display_from_sheet, shot.printed_width_mm / picture.width(),
          std::make_shared<const Image<Rgb>>(std::move(light))};
}

std::span<const View> CamerasOf(const Shot& shot, const std::vector<View>& cameras) {
  const std::span<const View> all(cameras);
  const auto count = static_cast<std::size_t>(shot.cameras);
  return count > 0 && count < all.size() ? all.first(count) : all;
}

PrototypeCamera CameraOf(const View& view, const SynthPhotosOptions& options) {
  return {view.camera,      view.camera_from_world, options.aperture_mm,
          options.focus_mm, options.vignetting,     options.blur_px};
}

Json SensorJson(const SynthPhotosOptions& options, const Sensor& sensor) {
  Json json = {{"samples", options.samples},
               {"aperture_mm", options.aperture_mm},
               {"focus_mm", options.focus_mm},
               {"vignetting", options.vignetting},
               {"blur_px", options.blur_px},
               {"exposure", sensor.exposure},
               {"full_well_e", sensor.full_well_e},
               {"read_noise_e", sensor.read_noise_e},
               {"pedestal", sensor.pedestal},
               {"curve", options.format == "exr" ? "linear" : options.curve},
               {"bits", sensor.bits},
               {"seed", options.seed}};
  if (json["curve"] == "gamma") json["gamma"] = options.gamma;
  return json;
}

// A photograph to take: of which shot, from where and into which file, with which noise.
struct Taken {
  const Shot* shot;
  View photo;
  std::string camera;
  std::uint64_t seed;
};

// Every shot from each of its cameras.
std::vector<Taken> ToTake(const SynthPhotosOptions& options, const std::vector<Shot>& shots,
                          const std::vector<View>& cameras, const fs::path& out) {
  std::vector<Taken> all;
  for (const Shot& shot : shots) {
    for (const View& view : CamerasOf(shot, cameras)) {
      const auto seed = (static_cast<std::uint64_t>(options.seed) << 32) + all.size();
      Taken taken{&shot, view, view.name, seed};
      taken.photo.name = PhotoName(view, shot, shots.size());
      taken.photo.image = out / "images" / fmt::format("{}.{}", taken.photo.name, options.format);
      all.push_back(std::move(taken));
    }
  }
  return all;
}

Json RecordOf(const Taken& taken) {
  Json record = {{"file", ("images" / taken.photo.image.filename()).string()},
                 {"camera", taken.camera},
                 {"shot", taken.shot->name}};
  if (taken.shot->exposure != 1) record["exposure"] = taken.shot->exposure;
  return record;
}

// What is beside the photographs.
void WriteTruth(const fs::path& out, const std::vector<Taken>& all, const Calibration& calibration,
                const Json& sensor) {
  TransformsJson transforms;
  Json photos = Json::array();
  for (const Taken& taken : all) {
    transforms.views.push_back(taken.photo);
    photos.push_back(RecordOf(taken));
  }
  WriteTransformsJson(out / "transforms.json", transforms);
  SaveCalibration(out / "calibration.json", calibration);
  const Json record = {{"format_version", kPhotosVersion},
                       {"display", calibration.display},
                       {"sensor", sensor},
                       {"photos", photos}};
  WriteTextAtomically(out / "photos.json", record.dump(1) + "\n");
}

// That no other shot has: with crosstalk between slots every slot's are its own.
double NumImages(const Shot& shot, const Truth& truth) {
  if (truth.slot_crosstalk == 0)
    return static_cast<double>(FilesOf(shot, truth.calibration).size());
  double slots = 0;
  for (const Shot::LayerFiles& layer : shot.layers) {
    slots += static_cast<double>(layer.emitter.size() + layer.modulator.size());
  }
  return slots;
}

// How many shots are photographed together, for lines of sight to be traced once: by the memory of
// their photographs and of the images that each has for itself.
std::size_t ShotsAtOnce(const std::vector<const Taken*>& left, const Truth& truth, bool blurs) {
  constexpr double kBytes = 512.0 * 1024 * 1024;
  double photo_px = 0, panel_px = 0, images = 1;
  for (const Taken* taken : left) {
    const Camera& camera = taken->photo.camera;
    photo_px = std::max(photo_px, static_cast<double>(camera.width) * camera.height);
    images = std::max(images, NumImages(*taken->shot, truth));
  }
  for (const LayerCalibration& layer : truth.calibration.layers) {
    panel_px =
        std::max(panel_px, static_cast<double>(layer.emitter.width_px) * layer.emitter.height_px);
  }
  // Bands in work, of half pixels, are at most three times the photographs they become.
  const double bytes = sizeof(Rgb) * (photo_px * (blurs ? 4 : 1) + images * panel_px);
  return static_cast<std::size_t>(std::clamp(kBytes / bytes, 1.0, 16.0));
}

// Of some shots, `exposure` being that of one with a factor of 1.
void TakeTogether(std::span<const Taken* const> together, const SynthPhotosOptions& options,
                  const Truth& truth, double exposure, ShotLoader& loader, Progress& progress) {
  const std::optional<Rigid> board_place = PlaceOfPrintedBoard(options.printed_board);
  std::map<const Shot*, Show> shows;
  std::map<std::string, std::vector<const Taken*>> by_camera;
  for (const Taken* taken : together) {
    by_camera[taken->camera].push_back(taken);
    const Shot& shot = *taken->shot;
    if (shows.contains(&shot)) continue;
    Show& show = shows[&shot];
    show.layers = loader.Load(shot);
    if (board_place && !shot.printed.empty()) {
      show.sheet = SheetOf(shot, *board_place, exposure * shot.exposure);
    }
  }
  for (const auto& [camera, photos] : by_camera) {
    std::vector<Show> seen;
    for (const Taken* taken : photos) seen.push_back(shows.at(taken->shot));
    const std::vector<Image<Rgb>> lights = PhotographShows(
        truth.calibration, seen, CameraOf(photos[0]->photo, options), options.samples, progress);
    ParallelForEach(0, std::ssize(lights), [&, &of_camera = photos](std::int64_t i) {
      const Taken& taken = *of_camera[static_cast<std::size_t>(i)];
      const Sensor sensor = SensorOf(options, exposure * taken.shot->exposure);
      const Image<Rgb>& light = lights[static_cast<std::size_t>(i)];
      WritePhotograph(taken.photo.image, Develop(light.span(), sensor, taken.seed), options);
    });
  }
}

void Take(const std::vector<const Taken*>& left, const SynthPhotosOptions& options,
          const Truth& truth, double exposure, Progress& progress) {
  std::int64_t rows = 0;
  for (const Taken* taken : left) rows += taken->photo.camera.height;
  progress.Start("photographs", rows, "rows");
  const std::size_t most = ShotsAtOnce(left, truth, options.blur_px > 0);
  ShotLoader loader(truth.calibration, truth.slot_crosstalk);
  for (auto first = left.begin(); first != left.end();) {
    std::set<const Shot*> shots;
    const auto end = std::find_if(first, left.end(), [&](const Taken* taken) {
      shots.insert(taken->shot);
      return shots.size() > most;
    });
    TakeTogether({first, end}, options, truth, exposure, loader, progress);
    first = end;
  }
}

// All that the photographs depend on.
std::string DependOn(const SynthPhotosOptions& options, const Truth& truth, double exposure,
                     const std::vector<Shot>& shots) {
  SynthPhotosOptions asked = options;
  std::string text = ProgramVersion() + ToToml({Describe(asked)}) +
                     CalibrationText(truth.calibration) +
                     fmt::format("{} {}", truth.slot_crosstalk, exposure);
  std::set<fs::path> files;
  if (!options.cameras.empty()) files.insert(options.cameras);
  if (!options.shots.empty()) files.insert(options.shots);
  for (const Shot& shot : shots) files.merge(FilesOf(shot, truth.calibration));
  for (const fs::path& file : files) {
    text += fmt::format("\n{} {}", file.string(), ContentHashOfFile(file));
  }
  return text;
}

}  // namespace

OptionTable Describe(SynthPhotosOptions& o) {
  const auto text = [](const char* name, const char* help, std::string* value, const char* flag) {
    return OptionField{name, help, value, {}, {}, {}, flag};
  };
  const auto number = [](const char* name, const char* help, OptionValue value, double min,
                         double max, const char* flag) {
    return OptionField{name, help, value, min, max, {}, flag};
  };
  return {
      "synth",
      {text("display",
            "name or file, with what its panels lack; else that of the frames' workspace",
            &o.display, "--display"),
       text(
           "misalignment",
           "calibration.json of what it really is; else that of the frames' layers, or as designed",
           &o.misalignment, "--misalignment,--calibration"),
       text("frames", "a workspace's frames/ that it shows", &o.frames, "--frames"),
       text("shots", "a file of pictures that it shows in turn", &o.shots, "--shots"),
       text("cameras", "transforms.json of cameras in the display's frame, mm", &o.cameras,
            "--cameras"),
       text("eyes", "cameras \"X,Y,Z;...\" in mm whose pictures lie on z = 0", &o.eyes, "--eyes"),
       number("views", "cameras on two rings about the axis", &o.views, 0, 1000, "--views"),
       text("raster",
            "of the eyes' pictures on z = 0, LEFT,TOP,PIXEL,WIDTH,HEIGHT; else the panel's",
            &o.raster, "--raster"),
       text("printed_board",
            "where a printed board's middle is fixed, X,Y,Z mm or X,Y,Z,RX,RY,RZ with degrees; "
            "else its shots are left out",
            &o.printed_board, "--printed-board"),
       number("distance_mm", "of the rings' cameras, varied by 12 %, mm", &o.distance_mm, 1, 1e6,
              "--distance-mm"),
       number("tilt_deg", "of the outer ring, a third of it of the inner one, degrees", &o.tilt_deg,
              0, 85, "--tilt-deg"),
       number("width_px", "of the rings' pictures, px; 3:2", &o.width_px, 16, 16384, "--width-px"),
       number("k1", "radial distortion of the rings' cameras", &o.k1, -1, 1, "--k1"),
       number("samples",
              "lines of sight per pixel through lenses, a pupil or to paper, or onto many panel "
              "pixels; "
              "powers of two are best",
              &o.samples, 1, 65536, "--samples"),
       number("aperture_mm", "diameter of the pupil, mm; 0: all is sharp", &o.aperture_mm, 0, 1000,
              "--aperture-mm"),
       number("focus_mm", "distance of the sharp plane along the axis, mm", &o.focus_mm, 0, 1e9,
              "--focus-mm"),
       number("vignetting", "share of light lost in the corners", &o.vignetting, 0, 1,
              "--vignetting"),
       number("blur_px", "sigma of the Gaussian by which the lens spreads light, px", &o.blur_px, 0,
              50, "--blur-px"),
       number("exposure",
              "factor from light to full scale; else a layer's white emitters are white, with "
              "--shots 0.8 of it",
              &o.exposure, 1e-9, 1e9, "--exposure"),
       number("full_well_e", "electrons of full scale; 0: no noise", &o.full_well_e, 0, 1e9,
              "--full-well-e"),
       number("read_noise_e", "standard deviation, electrons", &o.read_noise_e, 0, 1e6,
              "--read-noise-e"),
       number("pedestal", "added to the light, share of full scale", &o.pedestal, 0, 0.5,
              "--pedestal"),
       OptionField{"curve",
                   "of the PNG's numbers",
                   &o.curve,
                   {},
                   {},
                   {"srgb", "linear", "gamma"},
                   "--curve"},
       number("gamma", "number = light^(1/gamma) where the curve is gamma", &o.gamma, 0.1, 10,
              "--gamma"),
       number("bits", "of the PNG's numbers; above 8 in 16-bit files", &o.bits, 8, 16, "--bits"),
       OptionField{"format",
                   "png, or exr: linear, not rounded",
                   &o.format,
                   {},
                   {},
                   {"png", "exr"},
                   "--format"},
       number("seed", "of the noise", &o.seed, 0, 1e9, "--seed")}};
}

int SynthPhotos(const SynthPhotosOptions& options, const fs::path& out, Progress& progress) {
  const std::vector<Shot> shots = Shots(options);
  const Truth truth = TruthOf(options);
  const std::vector<View> cameras = PhotoCameras(options, truth.calibration);
  CheckNames(shots, cameras);
  if (options.aperture_mm > 0 && !(options.focus_mm > 0)) {
    throw UsageError("--aperture-mm", "has no --focus-mm", "give the distance of the sharp plane");
  }
  const double exposure = ExposureOf(options, shots, truth.calibration);
  CreateFolder(out / "images");
  const std::vector<Taken> all = ToTake(options, shots, cameras, out);
  std::vector<fs::path> photographs;
  for (const Taken& taken : all) photographs.push_back(taken.photo.image);
  const UnfinishedPhotos unfinished(out, DependOn(options, truth, exposure, shots), photographs);
  std::vector<const Taken*> left;
  for (const Taken& taken : all) {
    if (!unfinished.Has(taken.photo.image)) left.push_back(&taken);
  }
  if (left.size() < all.size()) {
    progress.Note(
        fmt::format("{} photographs of a run that was stopped are kept", all.size() - left.size()));
  }
  Take(left, options, truth, exposure, progress);
  WriteTruth(out, all, truth.calibration, SensorJson(options, SensorOf(options, exposure)));
  unfinished.Finish();
  return static_cast<int>(all.size());
}

}  // namespace lamella
