#include "pipeline/frames_record.h"

#include <algorithm>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <nlohmann/json.hpp>

#include "distribute/encode_barrier.h"
#include "distribute/stroke_order.h"
#include "lightfield/atomic_file.h"
#include "pipeline/json_file.h"

namespace lamella {
namespace fs = std::filesystem;
namespace {

using Json = nlohmann::ordered_json;

constexpr int kFormatVersion = 1;
constexpr const char* kRecordFile = "frames.json";
constexpr int kMostStrokes = 4096;

const char* NameOf(FrameRole role) { return role == FrameRole::kEmitter ? "emitter" : "modulator"; }

const char* KindOf(const Optics& optics) {
  if (std::holds_alternative<Barrier>(optics)) return "barrier";
  return std::holds_alternative<LensletArray>(optics) ? "lenslets" : "lenticular";
}

Json FramesOf(const Layer& layer, int index) {
  const int k = SlotsPerAxis(layer);
  std::vector<FrameRole> roles{FrameRole::kEmitter};
  if (std::holds_alternative<Barrier>(layer.optics)) roles.push_back(FrameRole::kModulator);
  Json frames = Json::array();
  for (int slot = 0; slot < k * k; ++slot) {
    for (const FrameRole role : roles) {
      frames.push_back({{"file", FrameFile(index, slot, role)},
                        {"role", NameOf(role)},
                        {"slot", slot},
                        {"slot_x", slot % k},
                        {"slot_y", slot / k}});
    }
  }
  return frames;
}

Json LayersJson(const Display& display, bool with_frames) {
  Json layers = Json::array();
  for (std::size_t l = 0; l < display.layers.size(); ++l) {
    const Layer& layer = display.layers[l];
    const int k = SlotsPerAxis(layer);
    layers.push_back(
        {{"layer", l},
         {"position_mm", layer.position_mm},
         {"optics", KindOf(layer.optics)},
         {"mirror_x", layer.mirror_x},
         {"slots_per_axis", k},
         {"order", SlotOrder(k)},
         {"frames", with_frames ? FramesOf(layer, static_cast<int>(l)) : Json::array()}});
  }
  return layers;
}

// When in a stroke each exposure has its middle, were the focus to move so.
Json PhasesOf(const Varifocal& varifocal, FocusSweep sweep, int stroke) {
  Json phases = Json::array();
  for (const ShownPlane& shown : StrokeSchedule(varifocal, sweep, stroke)) {
    phases.push_back(shown.phase);
  }
  return phases;
}

Json TimingOf(const Varifocal& varifocal, int stroke) {
  return {{"planes", StrokeOrder(varifocal.planes, stroke)},
          {"phases",
           {{"uniform", PhasesOf(varifocal, FocusSweep::kUniform, stroke)},
            {"sinusoidal", PhasesOf(varifocal, FocusSweep::kSinusoidal, stroke)}}}};
}

Json FrameOfStroke(const std::string& file, int stroke, bool there_and_back) {
  return {{"file", file},
          {"stroke", stroke},
          {"direction", there_and_back && stroke % 2 != 0 ? "falling" : "rising"}};
}

Json StrokesJson(const Display& display, const StrokeFrames& strokes) {
  const bool back = strokes.packing.there_and_back;
  Json frames = Json::array(), numerals = Json::array();
  for (int t = 0; t < strokes.strokes; ++t) frames.push_back(FrameOfStroke(StrokeFile(t), t, back));
  for (int t = 0; strokes.numerals && t < NumeralStrokes(strokes); ++t) {
    numerals.push_back(FrameOfStroke(NumeralsFile(t), t, back));
  }
  Json timing = {{"rising", TimingOf(*display.varifocal, 0)}};
  if (back) timing["falling"] = TimingOf(*display.varifocal, 1);
  return {{"count", strokes.strokes},
          {"method", strokes.method},
          {"mirror_x", display.layers.front().mirror_x},
          {"packing",
           {{"planes", strokes.planes},
            {"channel_order", NameOf(strokes.packing.channels)},
            {"bit_order", NameOf(strokes.packing.bits)},
            {"there_and_back", back}}},
          {"timing", timing},
          {"frames", frames},
          {"numerals", numerals}};
}

std::string OneOf(const JsonObject& json, const std::string& key,
                  const std::vector<std::string>& names) {
  std::string name = json.Text(key);
  if (std::find(names.begin(), names.end(), name) != names.end()) return name;
  throw json.Wrong(key, fmt::format("one of {}", fmt::join(names, ", ")));
}

}  // namespace

std::string FrameFile(int layer, int slot, FrameRole role) {
  return fmt::format("layer_{}_slot_{}_{}.png", layer, slot, NameOf(role));
}

std::string StrokeFile(int stroke) { return fmt::format("stroke_{}.png", stroke); }

std::string NumeralsFile(int stroke) {
  return stroke % 2 == 0 ? "numerals.png" : "numerals_back.png";
}

int NumeralStrokes(const StrokeFrames& strokes) { return strokes.packing.there_and_back ? 2 : 1; }

void SaveFramesRecord(const fs::path& folder, const Display& display, const FramesRecord& record) {
  Json response = {{"curve", record.strokes ? "none" : record.curve}};
  if (response["curve"] == "gamma") response["gamma"] = record.gamma;
  Json json = {{"format_version", kFormatVersion},
               {"display", display.name},
               {"panel",
                {{"width_px", display.width_px},
                 {"height_px", display.height_px},
                 {"pitch_mm", display.pitch_mm}}},
               {"bit_depth", record.strokes ? 1 : 8},
               {"response", response},
               {"layers", LayersJson(display, !record.strokes)}};
  if (record.strokes) json["strokes"] = StrokesJson(display, *record.strokes);
  WriteTextAtomically(folder / kRecordFile, json.dump(1) + "\n");
}

std::optional<StrokeFrames> LoadStrokeFrames(const fs::path& folder) {
  const JsonObject json(folder / kRecordFile);
  json.CheckFormatVersion(kFormatVersion);
  if (!json.Has("strokes")) return std::nullopt;
  const JsonObject strokes = json.Object("strokes"), packing = strokes.Object("packing");
  return StrokeFrames{
      strokes.Text("method"),
      strokes.Whole("count", 1, kMostStrokes),
      packing.Whole("planes", 1, kMaxBitPlanes),
      {ChannelOrderOf(OneOf(packing, "channel_order", ChannelOrderNames())),
       BitOrderOf(OneOf(packing, "bit_order", BitOrderNames())), packing.Truth("there_and_back")},
      !strokes.Objects("numerals").empty()};
}

}  // namespace lamella
