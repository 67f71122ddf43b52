#include "calibration/varifocal_state.h"

#include <fmt/format.h>

#include "calibration/column_maker.h"

namespace lamella {
VarifocalColumns ColumnsOf(const VarifocalObservations& observations, std::size_t num_planes,
                           const VarifocalGroups& free) {
  VarifocalColumns columns;
  Columns& common = columns.common;
  ColumnMaker maker{common};
  for (const VarifocalCamera& camera : observations.cameras) {
    common.camera.push_back(camera.known ? -1 : maker.Camera("camera " + camera.name, false));
  }
  common.num_camera = common.size;
  for (std::size_t i = 0; i < num_planes; ++i) {
    const std::string name = fmt::format("plane {}", i);
    columns.plane.push_back(maker.Pose(name, 0.05, 10));
    maker.Next(name + " magnification", 0.01, "");
    columns.bent.push_back({free.bow ? maker.Next(name + " bow", 2, "mm") : -1,
                            free.pincushion ? maker.Next(name + " pincushion", 0.01, "") : -1});
  }
  common.num_display = common.size;
  for (const VarifocalView& view : observations.views) {
    const bool known = view.camera_from_frame.has_value();
    common.view.push_back(known ? -1 : maker.Pose("view " + view.name, 0.1, 50));
  }
  common.first_slip = common.size;
  for (const VarifocalPhoto& photo : PhotosOf(observations)) {
    if (!free.slip) break;
    common.slip.push_back(maker.Next(photo.label + " slip x", 1, "px"));
    maker.Next(photo.label + " slip y", 1, "px");
  }
  return columns;
}

std::vector<PanelCalibration> PlanesOf(const Calibration& design) {
  std::vector<PanelCalibration> planes;
  for (const LayerCalibration& layer : design.layers) planes.push_back(layer.emitter);
  return planes;
}

PlaneShape ShapeOf(const PanelCalibration& panel) {
  PlaneShape shape;
  shape << panel.scale, panel.aspect, panel.skew, panel.bow_mm, panel.pincushion;
  return shape;
}

PanelCalibration WithShape(PanelCalibration panel, const PlaneShape& shape) {
  panel.scale = shape(0);
  panel.aspect = shape(1);
  panel.skew = shape(2);
  panel.bow_mm = shape(3);
  panel.pincushion = shape(4);
  return panel;
}

std::vector<VarifocalPhoto> PhotosOf(const VarifocalObservations& observations) {
  std::vector<VarifocalPhoto> photos;
  for (const PlanePhoto& photo : observations.photos) {
    photos.push_back({photo.plane, photo.view,
                      fmt::format("{} (plane {})", photo.photo, photo.plane), photo.points.size()});
  }
  for (std::size_t i = 0; i < observations.views.size(); ++i) {
    const VarifocalView& view = observations.views[i];
    photos.push_back(
        {-1, static_cast<int>(i), fmt::format("view {} (marks)", view.name), view.marks.size()});
  }
  return photos;
}

}  // namespace lamella
