// Writes a preview page of a known scene on a small display, and beside it, in frames/, what its
// panels show: page_fixture FILE.html
//
// A yellow F stands 15 mm in front of the reference plane, a white square lies on it at the left, a
// blue wall with a red right half and a green top stands 15 mm behind. Everything goes through the
// real simulation and the real page; only the encoder is the tests' plain one.
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <string>

#include "distribute/simulate_eye.h"
#include "lightfield/atomic_file.h"
#include "lightfield/image_io.h"
#include "pipeline/frame_pictures.h"
#include "pipeline/preview_eyes.h"
#include "pipeline/report/picture.h"
#include "pipeline/report/preview_page.h"
#include "pipeline/slot_frames.h"
#include "tests/reference/encode_reference.h"

namespace lamella {
namespace {

constexpr double kNear = 15, kFar = -15;

bool InsideF(double x, double y) {  // 16 x 24 mm, its stem at the left
  if (x < -8 || x > 8 || y < -12 || y > 12) return false;
  return x < -3 || y > 7 || (y > -2 && y < 3 && x < 4);
}

reference::SceneHit Scene(double x, double y, double slope_x, double slope_y) {
  const auto at = [&](double z) { return std::pair(x + slope_x * z, y + slope_y * z); };
  const auto [near_x, near_y] = at(kNear);
  if (InsideF(near_x, near_y)) return {{0.9F, 0.8F, 0}, kNear};
  if (std::abs(x + 35) < 6 && std::abs(y) < 6) return {{0.9F, 0.9F, 0.9F}, 0};
  const auto [far_x, far_y] = at(kFar);
  return {{far_x > 0 ? 0.5F : 0, far_y > 0 ? 0.4F : 0, 0.3F}, kFar};
}

Display SmallDisplay() {
  Display display;
  display.name = "fixture";
  display.width_px = 480;
  display.height_px = 360;
  display.pitch_mm = 0.25;
  display.viewing_distance_mm = 400;
  // Neighbouring emitters are seen D p / d0 = 20 mm apart: the positions are whole steps of it, and
  // what the test measures does not depend on where the eye stands within a step. Each layer's
  // emitters stand at the depth of the things it shows, where pinholes are sharp.
  const Barrier barrier{12, 4, 3};
  display.layers = {{-10, 5, barrier, true}, {5, 5, barrier, false}, {20, 5, barrier, false}};
  return display;
}

Image<Rgb8> TargetOf(const Eye& eye) {
  Image<Rgb> picture(eye.width, eye.height);
  for (int y = 0; y < eye.height; ++y) {
    for (int x = 0; x < eye.width; ++x) {
      const double x0 = eye.left_mm + (x + 0.5) * eye.pixel_mm,
                   y0 = eye.top_mm - (y + 0.5) * eye.pixel_mm;
      picture(x, y) = Scene(x0, y0, (eye.position.x() - x0) / eye.position.z(),
                            (eye.position.y() - y0) / eye.position.z())
                          .color;
    }
  }
  return EncodeSrgb8(picture.span());
}

PageDepthView DepthView() {
  DepthMap map{Image<float>(160, 120, 2.0F), Image<float>(160, 120, 1.0F)};
  for (int y = 0; y < 120; ++y) {
    for (int x = 0; x < 160; ++x) {
      map.depth(x, y) = x < 30 ? 0.0F : 1.0F + static_cast<float>(x) / 80;
    }
  }
  const Image<Rgb8> photo(160, 120, {90, 120, 150});
  return {"</script><b>fixture</b>", DataUri(photo.span(), "jpeg"),
          DataUri(ColoredDepth(map, ScaleOf({&map}), 160).span(), "png"), KnownShare(map), true};
}

void WriteFrames(const std::filesystem::path& folder, const Display& display,
                 const LayerImages& layers) {
  CreateFolder(folder);
  WriteTextAtomically(folder / "frames.json",
                      R"({"format_version": 1, "response": {"curve": "srgb"}})");
  for (std::size_t layer = 0; layer < layers.slots.size(); ++layer) {
    for (std::size_t slot = 0; slot < layers.slots[layer].size(); ++slot) {
      const EmitterImage& emitters = layers.slots[layer][slot];
      const auto all = [&](int, int) {
        return EmitterImage{emitters.color.Clone(), emitters.coverage.Clone()};
      };
      WriteSlotFrames(all, display, static_cast<int>(layer), static_cast<int>(slot),
                      PanelResponse::Srgb(), folder, display.emitter_rows());
    }
  }
}

PreviewPage Page(const std::filesystem::path& frames) {
  const Display display = SmallDisplay();
  const LayerImages layers = reference::EncodeCentreRays(display, Scene);
  PreviewPage page;
  page.title = "fixture";
  page.subtitle = "a known scene";
  page.distance_mm = display.viewing_distance_mm;
  page.clean_box_mm = CleanEyeBox(display);
  Eye eye;
  eye.pixel_mm = 0.5;
  eye.width = page.width = 216;
  eye.height = page.height = 156;
  eye.left_mm = -54;
  eye.top_mm = 39;
  for (int i = -3; i <= 3; ++i) {
    page.x_mm.push_back(20.0 * i);
    page.y_mm.push_back(-20.0 * i);
  }
  for (const double y : page.y_mm) {
    for (const double x : page.x_mm) {
      eye.position = {x, y, display.viewing_distance_mm};
      const EyePicture seen = SimulateEye(layers, display, eye);
      page.eyes.push_back({DataUri(EncodeSrgb8(seen.color.span()).span(), "jpeg", 95),
                           DataUri(TargetOf(eye).span(), "jpeg", 95), 30.0, 0.9, 1.0, 1.0});
    }
  }
  eye.position = {0, 0, display.viewing_distance_mm};
  page.pupil_mm = 20;
  for (const double plane : {kFar, 0.0, kNear}) {
    const EyePicture seen =
        SimulateEye(layers, display, FocusedOn(eye, plane), Pupil{page.pupil_mm, 24});
    page.focus.push_back({plane, DataUri(EncodeSrgb8(seen.color.span()).span(), "jpeg", 95),
                          DataUri(TargetOf(eye).span(), "jpeg", 95), 30.0, 0.9});
  }
  page.depth_views.push_back(DepthView());
  page.depth_ticks = {{0.0, "2.9"}, {1.0, "1.4"}};
  for (std::size_t l = 0; l < layers.slots.size(); ++l) {
    page.layers.push_back({"Layer " + std::to_string(l),
                           DataUri(EncodeSrgb8(layers.slots[l][0].color.span()).span(), "jpeg")});
  }
  WriteFrames(frames, display, layers);
  page.steps = StepsOfFrames(frames, display, OpenImages(layers));
  page.cutoff = SvgDataUri("<svg xmlns='http://www.w3.org/2000/svg' viewBox='0 0 64 32'/>");
  page.cutoff_text = "80 % are <b>sharp</b>";
  page.facts = {{"Display", display.name}};
  page.stages = {{"layers", 1.5, 100}};
  page.warnings = {"a warning with <i>markup</i>"};
  page.tables = {{"Captured views", {"view", "dB"}, {{"a", "40.0"}}}};
  return page;
}

}  // namespace
}  // namespace lamella

int main(int argc, char** argv) {
  if (argc != 2) {
    std::fputs("usage: page_fixture FILE.html\n", stderr);
    return 2;
  }
  const std::filesystem::path file = argv[1];
  lamella::WriteTextAtomically(file, lamella::ToHtml(lamella::Page(file.parent_path() / "frames")));
  return 0;
}
