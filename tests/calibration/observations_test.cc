#include "calibration/observations.h"

#include <limits>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "lightfield/error.h"

namespace lamella {
namespace {

Observations Good() {
  Observations observations;
  observations.cameras = {{"body", 400, 300, 0}};
  observations.photos = {{{0, PanelId::kEmitter}, 0, 0, "a.png", {Observation{}}},
                         {{0, PanelId::kModulator}, 0, 0, "b.png", {Observation{}}}};
  return observations;
}

std::string Complaint(const Observations& observations) {
  try {
    Check(observations, "photos.json");
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ExitCode::kInput);
    return error.what();
  }
  return "";
}

TEST(Observations, PassWhereNothingIsWrong) { EXPECT_EQ(Complaint(Good()), ""); }

TEST(Observations, AreRefusedWithTheNameOfThePhotograph) {
  using testing::HasSubstr;
  Observations bad = Good();
  bad.photos[1].points[0].image_px.x() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THAT(Complaint(bad),
              HasSubstr("layer 0 modulator of b.png has a point that is not finite"));
  bad = Good();
  bad.photos[1].points[0].covariance_px2 << 1, 2, 2, 1;
  EXPECT_THAT(Complaint(bad), HasSubstr("b.png has a covariance"));
  bad = Good();
  bad.photos[1].camera = 1;
  EXPECT_THAT(Complaint(bad), HasSubstr("b.png is of camera 1"));
  bad.cameras.push_back({"other", 400, 300, 0});
  EXPECT_THAT(Complaint(bad), HasSubstr("view 0 has photographs of two cameras"));
  bad = Good();
  bad.photos[1].panel = bad.photos[0].panel;
  bad.photos[1].photo = "a.png";
  EXPECT_THAT(Complaint(bad), HasSubstr("layer 0 emitter appears twice in a.png"));
  bad = Good();
  bad.cameras[0].width = 0;
  EXPECT_THAT(Complaint(bad), HasSubstr("camera body is 0 x 300 px"));
}

}  // namespace
}  // namespace lamella
