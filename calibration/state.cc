#include "calibration/state.h"

#include <algorithm>
#include <map>
#include <optional>
#include <set>

#include <fmt/format.h>

#include "calibration/column_maker.h"
#include "calibration/model.h"
#include "lightfield/error.h"

namespace lamella {
namespace {

bool Has(const Calibration& design, const PanelId& panel) {
  if (panel.layer < 0 || panel.layer >= static_cast<int>(design.layers.size())) return false;
  const LayerCalibration& layer = design.layers[static_cast<std::size_t>(panel.layer)];
  return panel.role == PanelId::kEmitter || layer.modulator.has_value();
}

// The panel that stands still: seen directly if there is one, and not behind glass that bends.
PanelId ReferenceOf(const Structure& structure) {
  std::optional<PanelId> best;
  const auto cost = [&](const PanelId& panel) {
    const LayerCalibration& layer = structure.design.layers[static_cast<std::size_t>(panel.layer)];
    const bool behind = panel.role == PanelId::kEmitter && layer.modulator.has_value();
    return 2 * behind + structure.Panel(panel).mirror_x;
  };
  for (const PanelId& panel : structure.panels) {
    if (!best || cost(panel) < cost(*best)) best = panel;
  }
  return *best;
}

Eigen::Quaterniond Turned(const Eigen::Vector3d& by, const Eigen::Quaterniond& rotation) {
  const double angle = by.norm();
  if (!(angle > 0)) return rotation;
  return (Eigen::Quaterniond(Eigen::AngleAxisd(angle, by / angle)) * rotation).normalized();
}

Rigid Moved(const Rigid& pose, const Vector6d& by) {
  return {Turned(by.head<3>(), pose.rotation), pose.translation + by.tail<3>()};
}

int AddRelation(ColumnMaker& maker, const std::string& of) {
  const int first = maker.columns.size;
  maker.Next(of + " offset x", 10, "mm");
  maker.Next(of + " offset y", 10, "mm");
  maker.Next(of + " gap", 5, "mm");
  for (const char* part : {"tilt x", "tilt y", "rotation"})
    maker.Next(of + " " + part, 0.05, "rad");
  return first;
}

bool Photographed(const Structure& structure, const PanelId& panel) {
  return std::binary_search(structure.panels.begin(), structure.panels.end(), panel);
}

void AddLayer(ColumnMaker& maker, const Structure& structure, int i, const FreeGroups& free) {
  const LayerCalibration& design = structure.design.layers[static_cast<std::size_t>(i)];
  const PanelId emitter{i, PanelId::kEmitter}, modulator{i, PanelId::kModulator};
  const bool has_emitter = Photographed(structure, emitter);
  const bool has_modulator = Photographed(structure, modulator);
  const std::string name = fmt::format("layer {}", i);
  const bool stack = (has_emitter || has_modulator) && structure.reference.layer != i;
  maker.columns.stack.push_back(stack ? maker.Pose(name, 0.1, 50) : -1);
  const bool relation = has_emitter && has_modulator;
  maker.columns.relation.push_back(relation ? AddRelation(maker, name) : -1);
  const auto shape = [&](const PanelId& panel, bool photographed) {
    std::array<int, 4> columns{-1, -1, -1, -1};
    if (!photographed) return columns;
    const bool reference = panel == structure.reference;
    const std::string of = NameOf(panel);
    if (free.scale && !reference) columns[0] = maker.Next(of + " scale", 0.01, "");
    if (free.aspect_skew && !reference) {
      columns[1] = maker.Next(of + " aspect", 0.01, "");
      columns[2] = maker.Next(of + " skew", 0.01, "");
    }
    if (free.bow) columns[3] = maker.Next(of + " bow", 2, "mm");
    return columns;
  };
  maker.columns.emitter_shape.push_back(shape(emitter, has_emitter));
  maker.columns.modulator_shape.push_back(shape(modulator, has_modulator));
  // Where the datasheet is in doubt, so is the material, or whether there is any: 0.5 from acrylic
  // to air. Known ten times better, one material can be told from another.
  const bool air = std::find(free.air.begin(), free.air.end(), i) != free.air.end();
  const bool index = free.index && relation && !air;
  maker.columns.index.push_back(index ? maker.Next(name + " index", 0.5, "") : -1);
  const bool plate = free.plate && design.plate && (has_emitter || has_modulator);
  maker.columns.plate.push_back(plate ? maker.Next(name + " plate thickness", 1, "mm") : -1);
}

void PlusShape(Eigen::Vector4d& shape, const std::array<int, 4>& columns,
               const Eigen::VectorXd& step) {
  for (std::size_t k = 0; k < 4; ++k) {
    if (columns[k] >= 0) shape(static_cast<int>(k)) += step(columns[k]);
  }
}

Eigen::Vector4d ShapeNumbers(const PanelCalibration& panel) {
  return {panel.scale, panel.aspect, panel.skew, panel.bow_mm};
}

void SetShape(PanelCalibration& panel, const Eigen::Vector4d& shape) {
  panel.scale = shape(0);
  panel.aspect = shape(1);
  panel.skew = shape(2);
  panel.bow_mm = shape(3);
}

}  // namespace

Camera CameraOf(const LensParameters& lens, int width_px, int height_px) {
  Camera camera;
  camera.model = CameraModel::kBrown;
  camera.width = width_px;
  camera.height = height_px;
  camera.fx = lens(0);
  camera.fy = lens(1);
  camera.cx = lens(2);
  camera.cy = lens(3);
  for (std::size_t i = 0; i < 5; ++i) camera.distortion[i] = lens(4 + static_cast<int>(i));
  return camera;
}

const PanelCalibration& Structure::Panel(const PanelId& panel) const {
  const LayerCalibration& layer = design.layers[static_cast<std::size_t>(panel.layer)];
  return panel.role == PanelId::kEmitter ? layer.emitter : *layer.modulator;
}

Structure StructureOf(const Observations& observations, const Calibration& design) {
  Structure structure;
  structure.design = design;
  std::map<int, int> camera_of_view;
  std::set<PanelId> panels;
  for (const PanelPhoto& photo : observations.photos) {
    if (!Has(design, photo.panel)) {
      throw UsageError(kSolveWhere,
                       fmt::format("{} shows {}, which display {} does not have", photo.photo,
                                   NameOf(photo.panel), design.display),
                       "give the display's own file");
    }
    const auto& layer = design.layers[static_cast<std::size_t>(photo.panel.layer)];
    if (layer.lattice) {
      throw UsageError(kSolveWhere, fmt::format("layer {} has a lens sheet", photo.panel.layer),
                       "calibrate displays of panels; lens sheets need phase patterns");
    }
    camera_of_view[photo.view] = photo.camera;
    panels.insert(photo.panel);
  }
  if (panels.empty()) {
    throw InputError(kSolveWhere, "no panel was found in any photograph", "photograph its pattern");
  }
  for (const auto& [view, camera] : camera_of_view) {
    structure.views.push_back(view);
    structure.camera_of_view.push_back(camera);
  }
  for (const PanelPhoto& photo : observations.photos) {
    const auto at = std::lower_bound(structure.views.begin(), structure.views.end(), photo.view);
    structure.view_of_photo.push_back(static_cast<int>(at - structure.views.begin()));
  }
  structure.panels.assign(panels.begin(), panels.end());
  structure.reference = ReferenceOf(structure);
  return structure;
}

Structure StructureOf(const Calibration& design) {
  Structure structure;
  structure.design = design;
  for (int layer = 0; layer < static_cast<int>(design.layers.size()); ++layer) {
    for (const PanelId& panel : {PanelId{layer, PanelId::kEmitter}, {layer, PanelId::kModulator}}) {
      if (Has(design, panel)) structure.panels.push_back(panel);
    }
  }
  structure.reference = ReferenceOf(structure);
  return structure;
}

Columns ColumnsOf(const Structure& structure, const FreeGroups& free,
                  const Observations& observations) {
  Columns columns;
  columns.k3 = free.k3;
  ColumnMaker maker{columns};
  for (const PhotoCamera& camera : observations.cameras) {
    columns.camera.push_back(maker.Camera("camera " + camera.name, free.k3));
  }
  columns.num_camera = columns.size;
  for (std::size_t i = 0; i < structure.design.layers.size(); ++i) {
    AddLayer(maker, structure, static_cast<int>(i), free);
  }
  columns.num_display = columns.size;
  for (const int view : structure.views) {
    columns.view.push_back(maker.Pose(fmt::format("view {}", view + 1), 0.1, 50));
  }
  columns.first_slip = columns.size;
  for (const PanelPhoto& photo : observations.photos) {
    if (!free.slip) break;
    columns.slip.push_back(maker.Next(photo.photo + " slip x", 1, "px"));
    maker.Next(photo.photo + " slip y", 1, "px");
  }
  return columns;
}

CalibrationState Plus(const CalibrationState& state, const Columns& columns,
                      const Eigen::VectorXd& step) {
  CalibrationState next = state;
  for (std::size_t i = 0; i < columns.camera.size(); ++i) {
    const int num = columns.k3 ? 9 : 8;
    next.cameras[i].head(num) += step.segment(columns.camera[i], num);
  }
  for (std::size_t i = 0; i < columns.view.size(); ++i) {
    next.camera_from_world[i] = Moved(state.camera_from_world[i], step.segment<6>(columns.view[i]));
  }
  for (std::size_t i = 0; i < columns.slip.size(); ++i) {
    next.slips_px[i] += step.segment<2>(columns.slip[i]);
  }
  for (std::size_t i = 0; i < next.layers.size(); ++i) {
    LayerState& layer = next.layers[i];
    if (columns.stack[i] >= 0) {
      layer.world_from_stack = Moved(layer.world_from_stack, step.segment<6>(columns.stack[i]));
    }
    if (columns.relation[i] >= 0) layer.relation += step.segment<6>(columns.relation[i]);
    PlusShape(layer.emitter_shape, columns.emitter_shape[i], step);
    PlusShape(layer.modulator_shape, columns.modulator_shape[i], step);
    if (columns.index[i] >= 0) layer.index += step(columns.index[i]);
    if (columns.plate[i] >= 0) layer.plate_mm += step(columns.plate[i]);
  }
  return next;
}

CalibrationState StateOfDesign(const Structure& structure, const Observations& observations) {
  CalibrationState state;
  state.cameras.assign(observations.cameras.size(), LensParameters::Zero());
  state.camera_from_world.resize(structure.views.size());
  state.slips_px.assign(observations.photos.size(), Eigen::Vector2d::Zero());
  const std::vector<LayerCalibration>& layers = structure.design.layers;
  const Rigid world_from_display =
      Inverse(layers[static_cast<std::size_t>(structure.reference.layer)].display_from_stack);
  for (const LayerCalibration& design : layers) {
    LayerState layer;
    layer.world_from_stack = world_from_display * design.display_from_stack;
    layer.relation << design.offset_mm, design.gap_mm, design.rotation_rad;
    layer.emitter_shape = ShapeNumbers(design.emitter);
    if (design.modulator) layer.modulator_shape = ShapeNumbers(*design.modulator);
    layer.index = design.index;
    if (design.plate) layer.plate_mm = design.plate->thickness_mm;
    state.layers.push_back(layer);
  }
  return state;
}

Calibration CalibrationOf(const CalibrationState& state, const Structure& structure) {
  Calibration calibration = structure.design;
  const Rigid display_from_world =
      calibration.layers[static_cast<std::size_t>(structure.reference.layer)].display_from_stack;
  for (std::size_t i = 0; i < calibration.layers.size(); ++i) {
    LayerCalibration& layer = calibration.layers[i];
    const LayerState& from = state.layers[i];
    layer.display_from_stack = display_from_world * from.world_from_stack;
    layer.offset_mm = from.relation.head<2>();
    layer.gap_mm = from.relation(2);
    layer.rotation_rad = from.relation.tail<3>();
    layer.index = from.index;
    SetShape(layer.emitter, from.emitter_shape);
    if (layer.modulator) SetShape(*layer.modulator, from.modulator_shape);
    if (layer.plate) layer.plate->thickness_mm = from.plate_mm;
  }
  return calibration;
}

}  // namespace lamella
