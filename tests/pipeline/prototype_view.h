// A prototype that shows a display's emitters as frames, and the camera that sees what an eye does.
#pragma once

#include <memory>
#include <numbers>
#include <utility>

#include "datasets_synthetic/prototype.h"
#include "distribute/emitter_frame.h"
#include "distribute/encode_barrier.h"
#include "distribute/simulate_eye.h"
#include "lightfield/calibration.h"

namespace lamella {

// Of barriers with 9 slots, encoded to final codes of panels whose response is sRGB.
inline Prototype Showing(const Display& display, const Calibration& calibration,
                         const LayerImages& layers) {
  Prototype prototype{calibration, {}};
  for (std::size_t l = 0; l < layers.slots.size(); ++l) {
    const LayerCalibration& layer = prototype.calibration.layers[l];
    ShownLayer shown;
    for (int slot = 0; slot < 9; ++slot) {
      const Image<Rgb8> emitter = EmitterFrame(layers.slots[l][static_cast<std::size_t>(slot)],
                                               display, static_cast<int>(l), PanelResponse::Srgb());
      const Image<std::uint8_t> grey = ModulatorFrame(display, static_cast<int>(l), slot);
      Image<Rgb8> modulator(grey.width(), grey.height());
      for (std::size_t i = 0; i < grey.size(); ++i) {
        modulator.data()[i] = {grey.data()[i], grey.data()[i], grey.data()[i]};
      }
      shown.emitter.push_back(
          std::make_shared<Image<Rgb>>(LightOfEmitter(layer.emitter, emitter.span())));
      shown.modulator.push_back(std::make_shared<Image<float>>(
          TransmittanceOfModulator(*layer.modulator, modulator.span())));
    }
    prototype.shown.push_back(std::move(shown));
  }
  return prototype;
}

// The view camera whose picture is the eye's raster on z = 0.
inline PrototypeCamera CameraOf(const Eye& eye) {
  PrototypeCamera camera;
  const Eigen::Vector3d& e = eye.position;
  camera.camera = {CameraModel::kPinhole,
                   eye.width,
                   eye.height,
                   e.z() / eye.pixel_mm,
                   e.z() / eye.pixel_mm,
                   (e.x() - eye.left_mm) / eye.pixel_mm,
                   (eye.top_mm - e.y()) / eye.pixel_mm,
                   {}};
  camera.camera_from_display.rotation =
      Eigen::AngleAxisd(std::numbers::pi, Eigen::Vector3d::UnitX());
  camera.camera_from_display.translation = -(camera.camera_from_display.rotation * e);
  return camera;
}

}  // namespace lamella
