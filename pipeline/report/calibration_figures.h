// Figures of a calibration's page, as SVG in HTML; colours follow the page's.
#pragma once

#include <string>

#include "calibration/calibrate.h"

namespace lamella {

std::string EscapedHtml(const std::string& text);

// The rays' standard deviation through the panel's 7 x 5 probed places: the RMS over eyes, px.
// Darkest at `limit_px`, of another colour beyond it.
std::string RayFigure(const CalibrationReport& report, const PanelId& panel, double limit_px);

// A panel's cells: as dark as they have points, with their number, and the mean residual as an
// arrow.
std::string ResidualFigure(const ResidualMap& map);

// Where cameras stood and eyes are, degrees from the reference panel's normal, and the next view.
std::string DirectionFigure(const CalibrationReport& report);

// chi^2 per degree of freedom of each.
std::string Chi2Figure(const std::vector<FitOf>& fits);

}  // namespace lamella
