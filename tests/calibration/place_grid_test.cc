// Places near a place, against asking all of them.
#include "calibration/place_grid.h"

#include <random>

#include <gtest/gtest.h>

namespace lamella {
namespace {

using Eigen::Vector2d;

std::vector<Vector2d> Scattered(std::size_t num, double width) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> even(-width / 2, width / 2);
  std::vector<Vector2d> places;
  for (std::size_t i = 0; i < num; ++i) {
    const double x = even(random), y = even(random);
    places.emplace_back(x, y);
  }
  return places;
}

TEST(PlaceGrid, FindsWhatAskingAllFinds) {
  for (const double radius : {0.01, 0.7, 3.0, 100.0}) {
    std::vector<Vector2d> places = Scattered(600, 20);
    places.insert(places.end(), {{0, 0}, {radius, 0}, {0, -radius}, {0, 0}, {2 * radius, radius}});
    const PlaceGrid grid(places, radius);
    for (const Vector2d& at : places) {
      std::vector<std::size_t> all;
      for (std::size_t i = 0; i < places.size(); ++i) {
        if ((places[i] - at).squaredNorm() <= radius * radius) all.push_back(i);
      }
      EXPECT_EQ(grid.Within(at), all);
    }
  }
}

// Of asking all these would be 10^10 distances, half a minute and more.
TEST(PlaceGrid, AnswersOfAHundredThousandPlaces) {
  const std::vector<Vector2d> places = Scattered(100000, 300);
  const PlaceGrid grid(places, 1.6);
  std::size_t found = 0;
  for (const Vector2d& at : places) found += grid.Within(at).size();
  EXPECT_NEAR(static_cast<double>(found), 1e5 * (1 + 1e5 * 8.04 / 9e4), 0.02 * 1e6);
}

TEST(PlaceGrid, HoldsPlacesFarAwayAndNone) {
  EXPECT_TRUE(PlaceGrid({}, 1).Within({0, 0}).empty());
  const PlaceGrid grid({{1e300, 0}, {-1e12, 5}}, 1e-3);
  EXPECT_EQ(grid.Within({1e300, 0}), std::vector<std::size_t>{0});
  EXPECT_TRUE(grid.Within({0, 0}).empty());
}

}  // namespace
}  // namespace lamella
