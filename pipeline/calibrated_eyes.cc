#include "pipeline/calibrated_eyes.h"

#include <algorithm>
#include <memory>
#include <utility>

#include "distribute/encode_barrier.h"
#include "distribute/panel_pixels-inl.h"
#include "lightfield/calibrated_map.h"
#include "lightfield/parallel.h"

namespace lamella {
namespace {

// Of a layer's light, the share that its openings let through over all slots.
double OpenShare(const Layer& layer) {
  const Barrier* barrier = std::get_if<Barrier>(&layer.optics);
  if (barrier == nullptr) return 1;
  const double open = static_cast<double>(barrier->aperture_px) / barrier->period_px;
  return open * open;
}

// Guard pixels are no unknown ones; behind barriers every emitter is lit in some opening's fan.
Image<float> LitEmitters(const Display& display, const Calibration& calibration, int layer) {
  Image<float> lit(display.emitter_columns(), display.emitter_rows(), 1);
  if (std::holds_alternative<Barrier>(display.layers[static_cast<std::size_t>(layer)].optics)) {
    return lit;
  }
  const CalibratedMap map(display, calibration, layer);
  ParallelForEach(0, lit.height(), [&](std::int64_t y) {
    for (int x = 0; x < lit.width(); ++x) {
      lit(x, static_cast<int>(y)) = map.BeamOf(0, 1, x, static_cast<int>(y)) ? 1.0F : 0.0F;
    }
  });
  return lit;
}

std::shared_ptr<const Image<float>> Transmittance(const Display& display,
                                                  const PanelCalibration& panel, int layer,
                                                  int slot) {
  const Image<std::uint8_t> grey = ModulatorFrame(display, layer, slot);
  Image<Rgb8> codes(grey.width(), grey.height());
  for (std::size_t i = 0; i < grey.size(); ++i) {
    codes.data()[i] = {grey.data()[i], grey.data()[i], grey.data()[i]};
  }
  return std::make_shared<Image<float>>(TransmittanceOfModulator(panel, codes.span()));
}

// The camera whose picture is the eye's raster, a view camera's: its sensor is upright.
PrototypeCamera CameraOf(const Eye& eye) {
  const Eigen::Vector3d& at = eye.position;
  const double focal = (at.z() - eye.plane_mm) / eye.pixel_mm;
  PrototypeCamera camera;
  camera.camera.width = eye.width;
  camera.camera.height = eye.height;
  camera.camera.fx = camera.camera.fy = focal;
  camera.camera.cx = (at.x() - eye.left_mm) / eye.pixel_mm;
  camera.camera.cy = (eye.top_mm - at.y()) / eye.pixel_mm;
  camera.camera_from_display.rotation = Eigen::Quaterniond(0, 1, 0, 0);  // y and z change sign
  camera.camera_from_display.translation = -(camera.camera_from_display.rotation * at);
  return camera;
}

}  // namespace

CalibratedEyes::CalibratedEyes(const LayersRecord& record, const LayerImages& shown)
    : light_{*record.calibration, {}}, known_{*record.calibration, {}} {
  const Display& display = record.display;
  for (std::size_t l = 0; l < display.layers.size(); ++l) {
    const Layer& layer = display.layers[l];
    const LayerCalibration& real = record.calibration->layers[l];
    const int index = static_cast<int>(l);
    const Image<float> lit = LitEmitters(display, *record.calibration, index);
    const auto scale = static_cast<float>(1 / (real.gain * OpenShare(layer)));
    ShownLayer light, known;
    for (std::size_t slot = 0; slot < shown.slots[l].size(); ++slot) {
      const EmitterImage& emitters = shown.slots[l][slot];
      light.emitter.push_back(std::make_shared<Image<Rgb>>(
          PanelFromEmitters<Rgb>(display, layer, lit.height(),
                                 [&](int x, int y) { return scale * emitters.color(x, y); })));
      known.emitter.push_back(std::make_shared<Image<Rgb>>(
          PanelFromEmitters<Rgb>(display, layer, lit.height(), [&](int x, int y) {
            return Rgb{lit(x, y) * emitters.coverage(x, y), lit(x, y), 0};
          })));
      if (real.modulator) {
        light.modulator.push_back(
            Transmittance(display, *real.modulator, index, static_cast<int>(slot)));
      }
    }
    known.modulator = light.modulator;
    const int k = SlotsPerAxis(layer);
    if (display.slot_crosstalk > 0 && k > 1) {
      light = WithSlotCrosstalk(light, SlotOrder(k), display.slot_crosstalk);
      known = WithSlotCrosstalk(known, SlotOrder(k), display.slot_crosstalk);
    }
    light_.shown.push_back(std::move(light));
    known_.shown.push_back(std::move(known));
  }
}

EyePicture CalibratedEyes::See(const Eye& eye, const std::optional<Pupil>& pupil,
                               int samples) const {
  PrototypeCamera camera = CameraOf(eye);
  if (pupil) {
    camera.aperture_mm = pupil->diameter_mm;
    camera.focus_mm = eye.position.z() - eye.plane_mm;
  }
  EyePicture seen{PhotographPrototype(light_, camera, samples, SilentProgress()),
                  Image<float>(eye.width, eye.height)};
  const Image<Rgb> known =
      PhotographPrototype(known_, camera, std::max(1, samples / 4), SilentProgress());
  for (std::size_t i = 0; i < known.size(); ++i) {
    const Rgb& share = known.data()[i];
    if (share.g > 0) seen.coverage.data()[i] = std::min(1.0F, share.r / share.g);
  }
  return seen;
}

}  // namespace lamella
