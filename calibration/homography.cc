#include "calibration/homography.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <random>
#include <vector>

#include <Eigen/Dense>

namespace lamella {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

// Moves points to mean 0 and mean square distance 2 (Hartley 1997).
Matrix3d Normalising(const Eigen::Matrix2Xd& points) {
  const Vector2d mean = points.rowwise().mean();
  const double spread =
      std::sqrt((points.colwise() - mean).squaredNorm() / (2 * static_cast<double>(points.cols())));
  Matrix3d m = Matrix3d::Identity();
  if (spread > 0) m.topLeftCorner<2, 2>() /= spread;
  if (spread > 0) m.topRightCorner<2, 1>() = -mean / spread;
  return m;
}

Eigen::Matrix2Xd Apply(const Matrix3d& m, const Eigen::Matrix2Xd& points) {
  return (m * points.colwise().homogeneous()).colwise().hnormalized();
}

bool NearALine(const Eigen::Matrix2Xd& points) {
  const Vector2d mean = points.rowwise().mean();
  const Eigen::Matrix2Xd centred = points.colwise() - mean;
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> eigen(centred * centred.transpose());
  return !(eigen.eigenvalues()(0) > 1e-6 * eigen.eigenvalues()(1));
}

// Two rows of the direct linear transform of one correspondence.
void Rows(const Vector2d& from, const Vector2d& to, Eigen::Ref<Eigen::MatrixXd> rows) {
  const double x = from.x(), y = from.y(), u = to.x(), v = to.y();
  rows.row(0) << x, y, 1, 0, 0, 0, -u * x, -u * y, -u;
  rows.row(1) << 0, 0, 0, x, y, 1, -v * x, -v * y, -v;
}

Matrix3d Direct(const Eigen::Matrix2Xd& from, const Eigen::Matrix2Xd& to,
                const std::vector<Eigen::Index>& use) {
  Eigen::Matrix<double, 9, 9> normal = Eigen::Matrix<double, 9, 9>::Zero();
  Eigen::MatrixXd rows(2, 9);
  for (const Eigen::Index i : use) {
    Rows(from.col(i), to.col(i), rows);
    normal += rows.transpose() * rows;
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix<double, 9, 9>> eigen(normal);
  const Eigen::Matrix<double, 9, 1> h = eigen.eigenvectors().col(0);
  return Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(h.data());
}

// Exactly through 4 points, with H(2, 2) = 1.
Matrix3d Through(const Eigen::Matrix2Xd& from, const Eigen::Matrix2Xd& to,
                 const std::array<Eigen::Index, 4>& use) {
  Eigen::MatrixXd rows(8, 9);
  for (int i = 0; i < 4; ++i) {
    Rows(from.col(use[static_cast<std::size_t>(i)]), to.col(use[static_cast<std::size_t>(i)]),
         rows.middleRows(2 * i, 2));
  }
  const Eigen::Matrix<double, 8, 8> left = rows.leftCols<8>();
  const Eigen::Matrix<double, 8, 1> h = left.partialPivLu().solve(-rows.col(8));
  Matrix3d m;
  m << h(0), h(1), h(2), h(3), h(4), h(5), h(6), h(7), 1;
  return m;
}

Eigen::VectorXd SquaredErrors(const Matrix3d& h, const Eigen::Matrix2Xd& from,
                              const Eigen::Matrix2Xd& to) {
  return (Apply(h, from) - to).colwise().squaredNorm();
}

double MedianOf(Eigen::VectorXd values) {
  if (!values.allFinite()) return std::numeric_limits<double>::infinity();
  const auto middle = values.begin() + values.size() / 2;
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

Matrix3d LeastMedian(const Eigen::Matrix2Xd& from, const Eigen::Matrix2Xd& to) {
  constexpr int kSamples = 120;  // all spoilt by 45 % wrong points: 1e-5
  std::mt19937 random(7);
  const auto num = static_cast<std::uint32_t>(from.cols());
  Matrix3d best = Matrix3d::Identity();
  double least = std::numeric_limits<double>::infinity();
  for (int sample = 0; sample < kSamples; ++sample) {
    std::array<Eigen::Index, 4> use{};
    for (Eigen::Index& i : use) i = static_cast<Eigen::Index>(random() % num);
    const Matrix3d h = Through(from, to, use);
    const double median = MedianOf(SquaredErrors(h, from, to));
    if (median < least) {
      least = median;
      best = h;
    }
  }
  return best;
}

}  // namespace

std::optional<Matrix3d> FitHomography(const Eigen::Matrix2Xd& plane,
                                      const Eigen::Matrix2Xd& image) {
  if (plane.cols() < 4 || NearALine(plane) || NearALine(image)) return std::nullopt;
  const Matrix3d normalise_plane = Normalising(plane), normalise_image = Normalising(image);
  const Eigen::Matrix2Xd from = Apply(normalise_plane, plane);
  const Eigen::Matrix2Xd to = Apply(normalise_image, image);
  Matrix3d h = LeastMedian(from, to);
  for (int round = 0; round < 3; ++round) {
    const Eigen::VectorXd errors = SquaredErrors(h, from, to);
    const double bound = std::max(9 / 1.386 * MedianOf(errors), 1e-18);  // 3 robust sigmas
    std::vector<Eigen::Index> use;
    for (Eigen::Index i = 0; i < errors.size(); ++i) {
      if (errors(i) <= bound) use.push_back(i);
    }
    if (use.size() < 4) return std::nullopt;
    h = Direct(from, to, use);
  }
  h = (normalise_image.inverse() * h * normalise_plane).eval();
  if (!h.allFinite()) return std::nullopt;
  return h;
}

Rigid PoseOfHomography(const Matrix3d& normalised_from_plane) {
  Matrix3d m = normalised_from_plane /
               std::sqrt(normalised_from_plane.col(0).norm() * normalised_from_plane.col(1).norm());
  if (m(2, 2) < 0) m = -m;
  Matrix3d rotation;
  rotation << m.col(0), m.col(1), m.col(0).cross(m.col(1));
  const Eigen::JacobiSVD<Matrix3d> svd(rotation, Eigen::ComputeFullU | Eigen::ComputeFullV);
  rotation = svd.matrixU() * svd.matrixV().transpose();
  return {Eigen::Quaterniond(rotation), m.col(2)};
}

double FocalOfHomographies(const std::vector<Eigen::Matrix3d>& image_from_plane, int width,
                           int height) {
  const double size = std::max(width, height);
  Eigen::Matrix3d scaled = Eigen::Matrix3d::Identity();  // centred, in units of the size
  scaled(0, 0) = scaled(1, 1) = 1 / size;
  scaled(0, 2) = -width / (2 * size);
  scaled(1, 2) = -height / (2 * size);
  std::vector<std::pair<double, double>> votes;  // 1/f^2, weight
  double total = 0;
  for (const Eigen::Matrix3d& homography : image_from_plane) {
    Eigen::Matrix3d h = scaled * homography;
    h /= h.leftCols<2>().topRows<2>().norm();
    const Eigen::Vector2d a(h.col(0).head<2>().dot(h.col(1).head<2>()),
                            h.col(0).head<2>().squaredNorm() - h.col(1).head<2>().squaredNorm());
    const Eigen::Vector2d b(h(2, 0) * h(2, 1), h(2, 0) * h(2, 0) - h(2, 1) * h(2, 1));
    if (!(a.squaredNorm() > 0)) continue;
    votes.emplace_back(-a.dot(b) / a.squaredNorm(), b.norm());
    total += votes.back().second;
  }
  std::sort(votes.begin(), votes.end());
  double sum = 0;
  for (const auto& [inverse_square, weight] : votes) {
    sum += weight;
    if (2 * sum < total) continue;
    const double focal = inverse_square > 0 ? size / std::sqrt(inverse_square) : 0;
    if (focal > 0.3 * size && focal < 30 * size) return focal;
    break;
  }
  return 1.3 * size;
}

}  // namespace lamella
