// Which views a photograph is matched with, and over which depths.
#pragma once

#include <optional>
#include <vector>

#include "lightfield/view.h"

namespace lamella {

struct Neighbour {
  int view = 0;
  double angle_deg = 0;  // median over the points that both see, between their lines of sight
  double score = 0;
};

// What the choice stands on: the capture's sparse points, or where there are none, points at the
// depth on which the views converge (or ten times their spacing), spread over every view.
class Neighbourhood {
 public:
  explicit Neighbourhood(const ViewSet& set);

  // The neighbours of a view, the best first, then by turns from the two sides of the first one's
  // baseline: what is hidden from one side is seen from the other. The score is the sum of
  //   exp(-(angle - 10 deg)^2 / (2 sigma^2)),   sigma = 5 deg below, 15 deg above
  // over the points that both see (after Yao et al. 2018), less where the neighbour is coarser.
  // Left out: views that share fewer than 20 points (or fewer than 30 % of the view's own, where
  // that is less), and views so near that they carry no depth (baseline / depth < 0.005).
  std::vector<Neighbour> Of(int view) const;

  // Depths (world units, along the optical axis) between which a view's points lie: 1 % and 99 %
  // quantiles. Nothing where fewer than 20 of them are measured.
  struct DepthRange {
    double near, far;
  };
  std::optional<DepthRange> MeasuredRange(int view) const;

 private:
  struct Point {
    Eigen::Vector3d position;  // from the middle of all views
    std::vector<int> views;
  };
  Neighbour Weigh(int view, int other, const std::vector<int>& common) const;

  std::vector<View> views_;  // around the middle
  std::vector<Point> points_;
  std::vector<std::vector<int>> seen_;  // by view: indices of points
  bool measured_ = false;
};

// The first of `neighbours` that lie within `max_angle_deg`, at most `most`; at least two of them
// where there are two.
std::vector<int> ChooseSources(const std::vector<Neighbour>& neighbours, double max_angle_deg,
                               int most);

}  // namespace lamella
