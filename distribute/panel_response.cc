#include "distribute/panel_response.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <Eigen/LU>
#include <fmt/format.h>

#include "lightfield/color.h"
#include "lightfield/error.h"

namespace lamella {
namespace {

// A layer's red, green and blue for light of the viewer's, both 1 at their most.
Eigen::Matrix3d PanelFromViewer(const Calibration& calibration, std::size_t layer) {
  const LayerCalibration& of = calibration.layers.at(layer);
  const Eigen::Matrix3d viewer_from_panel = of.gain * of.emitter.photometry.primaries;
  const Eigen::FullPivLU<Eigen::Matrix3d> inverse(viewer_from_panel);
  if (!inverse.isInvertible()) {
    throw InputError(fmt::format("calibration of \"{}\"", calibration.display),
                     fmt::format("the light of layer {} cannot be told apart by colour", layer),
                     "mend its gain and primaries");
  }
  return inverse.inverse();
}

}  // namespace

double CommonWhite(const Calibration& calibration) {
  double most = 0;
  for (std::size_t layer = 0; layer < calibration.layers.size(); ++layer) {
    const std::vector<double>& gains = calibration.layers[layer].emitter.photometry.evenness.gains;
    const double dimmest = *std::min_element(gains.begin(), gains.end());
    most = std::max(most, PanelFromViewer(calibration, layer).rowwise().sum().maxCoeff() / dimmest);
  }
  return 1 / most;
}

PanelResponse::PanelResponse(const std::function<double(double)>& light_from_encoded) {
  for (std::size_t code = 0; code < 255; ++code) {
    above_[code] = static_cast<float>(light_from_encoded((static_cast<double>(code) + 0.5) / 255));
  }
  above_[255] = std::numeric_limits<float>::infinity();
  std::size_t code = 0;
  for (std::size_t bin = 0; bin < kBins; ++bin) {
    while (static_cast<float>(bin) / kBins >= above_[code]) ++code;
    first_[bin] = static_cast<std::uint8_t>(code);
  }
}

PanelResponse PanelResponse::Srgb() {
  return PanelResponse([](double encoded) {
    return static_cast<double>(SrgbToLinear(static_cast<float>(encoded)));
  });
}

PanelResponse PanelResponse::Of(const Calibration& calibration, int layer) {
  const std::size_t l = static_cast<std::size_t>(layer);
  const Photometry& photometry = calibration.layers.at(l).emitter.photometry;
  PanelResponse response([&](double encoded) {
    return photometry.black + (1 - photometry.black) * LightOfCode(photometry.curve, encoded);
  });
  response.mixes_ = true;
  response.evenness_ = photometry.evenness;
  response.is_even_ = photometry.evenness == GainMap();
  const Eigen::Matrix3d mix = CommonWhite(calibration) * PanelFromViewer(calibration, l);
  for (std::size_t row = 0; row < 3; ++row) {
    for (std::size_t column = 0; column < 3; ++column) {
      response.mix_[row][column] = static_cast<float>(
          mix(static_cast<Eigen::Index>(row), static_cast<Eigen::Index>(column)));
    }
  }
  return response;
}

PanelResponse PanelResponse::Gamma(double exponent) {
  return PanelResponse([exponent](double encoded) { return std::pow(encoded, exponent); });
}

}  // namespace lamella
