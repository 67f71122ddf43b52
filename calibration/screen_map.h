// Which point of a panel every pixel of a photograph sees, and grid observations from that.
#pragma once

#include <complex>
#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include "calibration/observations.h"
#include "lightfield/image.h"

namespace lamella {

// Of one camera's photographs of one panel, taken without moving it. Pixels where `valid` is 0 are
// not known, whatever the others hold.
struct ScreenMap {
  Image<float> u_px, v_px;        // seen at the centre of the photograph's pixel
  Image<float> sigma_u, sigma_v;  // standard deviations, panel px
  Image<std::uint8_t> valid;
  // Of photographs through lenses alone, also where a pixel sees several and is not valid: the
  // sinusoids of all series, sqrt(N/2) B e^(i phi), which are linear in light and have the noise of
  // one photograph each; 0 in pixels that are dark or overexposed.
  std::vector<Image<std::complex<float>>> sinusoids = {};
  int width() const { return valid.width(); }
  int height() const { return valid.height(); }
};

// The nodes as the photograph shows them: around each, a homography is fitted from the photograph
// to the panel (Moreno and Taubin 2012) in the smallest window of 21 x 21 to 41 x 41 px of which
// enough is valid, without what lies further off than 4 sigma, and inverted at the node. The
// covariance is the fit's, from its residuals. Nodes that were not seen are left out.
std::vector<Observation> ObserveNodes(const ScreenMap& map,
                                      const std::vector<Eigen::Vector2d>& nodes_px);

// Where a panel of this size is observed: about 24 x 13 nodes, half a step from its edges.
std::vector<Eigen::Vector2d> NodesOf(int width_px, int height_px);

}  // namespace lamella
