#include "pipeline/layers_record.h"

#include <limits>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "distribute/displays.h"
#include "lightfield/atomic_file.h"
#include "lightfield/error.h"
#include "tests/scratch.h"

namespace lamella {
namespace {

using ::testing::HasSubstr;

View Reference() {
  View view;
  view.name = "middle";
  view.camera = {CameraModel::kPinhole, 640, 480, 500, 501, 300, 250, {}};
  view.camera_from_world = {Eigen::Quaterniond(0.9, 0.1, 0.2, -0.3).normalized(), {1, 2, 1.0 / 3}};
  return view;
}

LayersRecord Record() {
  LayersRecord record;
  record.display = FindDisplay("paper-two-layer-half");
  record.placement =
      Place(Reference(), 0.7, std::numeric_limits<double>::infinity(), record.display, {}, nullptr);
  record.seen_share = 0.25;
  record.seen_share_in_picture = 1.0 / 3;
  return record;
}

TEST(LayersRecord, ReadsBackWhatItWrote) {
  const Workspace workspace(ScratchFolder());
  CreateFolder(workspace.Stage("layers"));
  const LayersRecord record = Record();
  SaveLayersRecord(workspace.Stage("layers"), record);
  const LayersRecord again = LoadLayersRecord(workspace);
  EXPECT_EQ(again.display, record.display);
  EXPECT_EQ(again.seen_share, record.seen_share);
  EXPECT_EQ(again.seen_share_in_picture, record.seen_share_in_picture);
  const Placement &p = again.placement, &q = record.placement;
  EXPECT_EQ(p.reference_view, "middle");
  EXPECT_EQ(p.display_from_world, q.display_from_world);
  EXPECT_EQ(p.camera_from_world.rotation.coeffs(), q.camera_from_world.rotation.coeffs());
  EXPECT_EQ(p.camera_from_world.translation, q.camera_from_world.translation);
  EXPECT_EQ(p.middle, q.middle);
  for (const auto field :
       {&Placement::viewing_distance_mm, &Placement::a, &Placement::b, &Placement::mm_per_view_px,
        &Placement::focal_px, &Placement::picture_width_mm, &Placement::picture_height_mm,
        &Placement::near, &Placement::far, &Placement::near_mm, &Placement::far_mm}) {
    EXPECT_EQ(p.*field, q.*field);
  }
}

TEST(LayersRecord, KeepsDisplaysOfAnyOptics) {
  const Workspace workspace(ScratchFolder());
  CreateFolder(workspace.Stage("layers"));
  LayersRecord record = Record();
  Display lenticular = FindDisplay("paper-one-layer");
  lenticular.layers[0].optics = Lenticular{4.5, -1.0 / 6, 9, 0.25, 4};
  Display lenslets = FindDisplay("paper-two-layer");
  lenslets.layers[0].optics =
      LensletArray{LensletArray::Lattice::kSquare, 7.3, 5, 0.25, -1.0 / 3, false, 2.8};
  lenslets.layers[0].magnification = 1.0 / 3;
  Display relayed = FindDisplay("paper-varifocal");
  relayed.border_mm = 1;
  relayed.varifocal->spacing = Varifocal::Spacing::kSinusoidal;
  relayed.varifocal->relay_focal_mm = 700.0 / 3;
  relayed.varifocal->magnification0 = 0.9;
  relayed.layers = PlanesOf(*relayed.varifocal, relayed.layers[0]);
  for (const Display& display : {FindDisplay("paper-varifocal"), FindDisplay("depth-fused"),
                                 lenticular, lenslets, relayed}) {
    record.display = display;
    SaveLayersRecord(workspace.Stage("layers"), record);
    EXPECT_EQ(LoadLayersRecord(workspace).display, display);
  }
}

TEST(LayersRecord, RefusesWhatItCannotUse) {
  const Workspace workspace(ScratchFolder());
  CreateFolder(workspace.Stage("layers"));
  const auto refusal = [&] {
    try {
      LoadLayersRecord(workspace);
    } catch (const Error& error) {
      return std::string(error.what());
    }
    return std::string("accepted");
  };
  EXPECT_THAT(refusal(), HasSubstr("layers.json"));
  const auto path = workspace.Stage("layers") / "layers.json";
  WriteTextAtomically(path, "{\"format_version\": 3}");
  EXPECT_THAT(refusal(), HasSubstr("newer lamella"));
  WriteTextAtomically(path, "{\"format_version\": 1}");
  EXPECT_THAT(refusal(), HasSubstr("older lamella; run `lamella layers` again"));
  WriteTextAtomically(path, "{\"format_version\": 2}");
  EXPECT_THAT(refusal(), HasSubstr("is damaged; run `lamella layers` again"));
  WriteTextAtomically(path, "{");
  EXPECT_THAT(refusal(), HasSubstr("is damaged"));
}

TEST(EmitterImage, KeepsColorAndCoverageToHalfPrecision) {
  const Workspace workspace(ScratchFolder());
  CreateFolder(workspace.Stage("layers"));
  Display display = FindDisplay("paper-one-layer");
  display.width_px = 12;
  display.height_px = 6;
  EmitterImage image{Image<Rgb>(12, 6), Image<float>(12, 6)};
  image.color(3, 1) = {0.1F, 2, 1e8F};
  image.coverage(3, 1) = 0.5F;
  image.coverage(4, 1) = 1;  // a shadow: black and known
  SaveEmitterImage(workspace.Stage("layers"), 0, 4, image);
  const EmitterImage again = LoadEmitterImage(workspace, display, 0, 4);
  EXPECT_NEAR(again.color(3, 1).r, 0.1F, 1e-4F);
  EXPECT_EQ(again.color(3, 1).g, 2);
  EXPECT_EQ(again.color(3, 1).b, 65504);
  EXPECT_EQ(again.coverage(3, 1), 0.5F);
  EXPECT_EQ(again.coverage(4, 1), 1);
  EXPECT_EQ(again.color(4, 1), Rgb());
  EXPECT_EQ(again.coverage(0, 0), 0);
  display.width_px = 18;
  EXPECT_THROW(LoadEmitterImage(workspace, display, 0, 4), Error);
  EXPECT_THROW(LoadEmitterImage(workspace, display, 0, 5), Error);
}

}  // namespace
}  // namespace lamella
