#include "pipeline/report/preview_page.h"

#include <cmath>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "pipeline/report/page_embedded.h"
#include "pipeline/report/picture.h"

namespace lamella {
namespace {

using Json = nlohmann::ordered_json;

// JSON has no infinity: equal pictures, which have that as PSNR, are told by a flag.
bool IsEqual(const std::optional<double>& psnr_db) { return psnr_db && std::isinf(*psnr_db); }
Json NumberOf(const std::optional<double>& value) {
  return value && std::isfinite(*value) ? Json(*value) : Json();
}

Json Eyes(const PreviewPage& page) {
  Json views = Json::array();
  for (const PageEye& eye : page.eyes) {
    views.push_back({{"simulated", eye.simulated},
                     {"target", eye.target},
                     {"psnr_db", NumberOf(eye.psnr_db)},
                     {"equal", IsEqual(eye.psnr_db)},
                     {"ssim", NumberOf(eye.ssim)},
                     {"known", eye.known},
                     {"seen", eye.seen}});
  }
  return {{"x_mm", page.x_mm},
          {"y_mm", page.y_mm},
          {"distance_mm", page.distance_mm},
          {"clean_box_mm", page.clean_box_mm},
          {"beyond_box", page.beyond_box},
          {"width", page.width},
          {"height", page.height},
          {"views", views}};
}

Json Focus(const PreviewPage& page) {
  Json planes = Json::array();
  for (const PageFocus& focus : page.focus) {
    planes.push_back({{"plane_mm", focus.plane_mm},
                      {"simulated", focus.simulated},
                      {"target", focus.target},
                      {"psnr_db", NumberOf(focus.psnr_db)},
                      {"equal", IsEqual(focus.psnr_db)},
                      {"ssim", NumberOf(focus.ssim)}});
  }
  return {{"pupil_mm", page.pupil_mm}, {"planes", planes}};
}

Json Depth(const PreviewPage& page) {
  Json views = Json::array(), ticks = Json::array(), colors = Json::array();
  for (const PageDepthView& view : page.depth_views) {
    views.push_back({{"name", view.name},
                     {"photo", view.photo},
                     {"depth", view.depth},
                     {"known", view.known},
                     {"reference", view.reference}});
  }
  for (const auto& [at, text] : page.depth_ticks) ticks.push_back({{"at", at}, {"text", text}});
  constexpr int kColors = 33;
  for (int i = 0; i < kColors; ++i) {
    const Rgb8 c = DepthColor(i / (kColors - 1.0));
    colors.push_back(fmt::format("#{:02x}{:02x}{:02x}", c.r, c.g, c.b));
  }
  return {{"views", views}, {"ticks", ticks}, {"colors", colors}, {"note", page.depth_note}};
}

Json Layers(const PreviewPage& page) {
  Json layers = Json::array();
  for (const PageLayer& layer : page.layers) {
    layers.push_back({{"caption", layer.caption}, {"mean", layer.mean}});
  }
  return layers;
}

Json Pictures(const PageSlot& slot) {
  Json pictures = Json::array();
  for (const PagePicture& picture : slot.pictures) {
    pictures.push_back(
        {{"picture", picture.picture}, {"caption", picture.caption}, {"is_part", picture.is_part}});
  }
  return pictures;
}

Json Steps(const PageSteps& steps) {
  Json layers = Json::array();
  for (const PageStepLayer& layer : steps.layers) {
    Json slots = Json::array();
    for (const PageSlot& slot : layer.slots) {
      slots.push_back({{"name", slot.name}, {"pictures", Pictures(slot)}});
    }
    const Rect& part = layer.part;
    layers.push_back(
        {{"part", {{"x", part.x}, {"y", part.y}, {"width", part.width}, {"height", part.height}}},
         {"slots", slots}});
  }
  return {{"note", steps.note},
          {"slot_name", steps.slot_name},
          {"width", steps.width},
          {"height", steps.height},
          {"layers", layers}};
}

Json Metrics(const PreviewPage& page) {
  Json tables = Json::array();
  for (const PageTable& table : page.tables) {
    tables.push_back({{"title", table.title}, {"columns", table.columns}, {"rows", table.rows}});
  }
  return {{"note", page.metrics_note}, {"tables", tables}};
}

Json ToJson(const PreviewPage& page) {
  Json stages = Json::array();
  for (const PageStage& stage : page.stages) {
    stages.push_back({{"stage", stage.stage},
                      {"seconds", stage.seconds},
                      {"peak_memory_mib", stage.peak_memory_mib}});
  }
  return {{"title", page.title},
          {"subtitle", page.subtitle},
          {"foot", page.foot},
          {"eyes", Eyes(page)},
          {"focus", Focus(page)},
          {"depth", Depth(page)},
          {"layers", Layers(page)},
          {"steps", Steps(page.steps)},
          {"facts", page.facts},
          {"cutoff", page.cutoff},
          {"cutoff_text", page.cutoff_text},
          {"stages", stages},
          {"warnings", page.warnings},
          {"metrics", Metrics(page)}};
}

// JSON inside a script element: a "</script>" or "<!--" in a view's name must not end it.
std::string ForScript(const Json& json) {
  // Names of files need not be UTF-8.
  const std::string text = json.dump(-1, ' ', false, Json::error_handler_t::replace);
  std::string safe;
  safe.reserve(text.size());
  for (const char c : text) {
    if (c == '<') {
      safe += "\\u003c";
    } else {
      safe += c;
    }
  }
  return safe;
}

}  // namespace

std::string ToHtml(const PreviewPage& page) {
  std::string html;
  std::string_view rest = kPageTemplate;
  const std::pair<std::string_view, std::string> parts[] = {{"@STYLE@", std::string(kPageStyle)},
                                                            {"@DATA@", ForScript(ToJson(page))},
                                                            {"@SCRIPT@", std::string(kPageScript)}};
  for (const auto& [mark, text] : parts) {  // in the template's order
    const std::size_t at = rest.find(mark);
    html.append(rest.substr(0, at)).append(text);
    rest.remove_prefix(at + mark.size());
  }
  return html.append(rest);
}

}  // namespace lamella
