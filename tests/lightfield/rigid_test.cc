#include "lightfield/rigid.h"

#include <cmath>

#include <Eigen/LU>
#include <gtest/gtest.h>

namespace lamella {
namespace {

using Eigen::Vector3d;

const Rigid kB{Eigen::Quaterniond(0.8, 0.1, -0.5, 0.3).normalized(), {1, -2, 3}};
const Rigid kC{Eigen::Quaterniond(-0.2, 0.7, 0.4, 0.1).normalized(), {-5, 0.5, 0.25}};
const Vector3d kPoint(0.3, -0.7, 2.5);

TEST(Rigid, IsComposedSoThatNamesMeet) {
  EXPECT_LT(((kC * kB) * kPoint - kC * (kB * kPoint)).norm(), 1e-12);
  EXPECT_LT((kB.Matrix() * kPoint.homogeneous() - kB * kPoint).norm(), 1e-12);
}

TEST(Rigid, InverseUndoesIt) {
  EXPECT_LT((Inverse(kB) * (kB * kPoint) - kPoint).norm(), 1e-12);
  EXPECT_LT((kB * Centre(kB)).norm(), 1e-12);
}

Eigen::Matrix3Xd Points() {
  Eigen::Matrix3Xd points(3, 5);
  points << 0, 1, 0, 2, -1, 0, 0, 1, 1, 3, 0, 0.5, 0, -1, 2;
  return points;
}

TEST(AlignSimilarity, FindsTheSimilarityThatWasApplied) {
  const Similarity truth{2.5, kB.rotation.toRotationMatrix(), {10, 20, -30}};
  const Eigen::Matrix3Xd from = Points();
  Eigen::Matrix3Xd to = from;
  for (int i = 0; i < to.cols(); ++i) to.col(i) = truth * Vector3d(from.col(i));
  const Similarity found = AlignSimilarity(from, to);
  EXPECT_NEAR(found.scale, 2.5, 1e-12);
  EXPECT_LT((found.rotation - truth.rotation).norm(), 1e-12);
  EXPECT_LT((found.translation - truth.translation).norm(), 1e-11);
}

TEST(AlignSimilarity, NeverMirrors) {
  const Eigen::Matrix3Xd from = Points();
  const Eigen::Matrix3Xd to = Vector3d(1, 1, -1).asDiagonal() * from;
  EXPECT_NEAR(AlignSimilarity(from, to).rotation.determinant(), 1, 1e-12);
}

TEST(AlignSimilarity, StaysFiniteWhereAllPointsAreOne) {
  const Eigen::Matrix3Xd from = Vector3d(1, 2, 3).replicate(1, 4);
  const Similarity found = AlignSimilarity(from, Points().leftCols(4));
  EXPECT_TRUE(std::isfinite(found.scale));
  EXPECT_TRUE(found.translation.allFinite());
}

TEST(AlignSimilarity, KeepsItsAccuracyFarFromTheOrigin) {
  const Eigen::Matrix3Xd from = Points().colwise() + Vector3d(1e7, -1e7, 1e7);
  Eigen::Matrix3Xd to = 3 * from;
  const Similarity found = AlignSimilarity(from, to);
  EXPECT_NEAR(found.scale, 3, 1e-7);
  for (int i = 0; i < from.cols(); ++i) {
    EXPECT_LT((found * Vector3d(from.col(i)) - Vector3d(to.col(i))).norm(), 1e-6);
  }
}

}  // namespace
}  // namespace lamella
