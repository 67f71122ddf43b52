#include "datasets_synthetic/cut_pixel.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <span>

namespace lamella {
namespace {

constexpr double kMostPieces = 64;
constexpr double kLeastShare = 1e-12;  // what is less is rounding

// A convex polygon. A piece lies between two cuts along each of four axes, which add a corner each.
class Piece {
 public:
  void Add(const OnPanels& corner) {
    // Rounding alone makes so many, of which some lie on one another.
    if (count_ < corners_.size()) corners_[count_++] = corner;
  }

  double Area(int x, int y) const {
    double twice = 0;
    for (std::size_t i = 2; i < count_; ++i) {
      const OnPanels a = corners_[i - 1] - corners_[0], b = corners_[i] - corners_[0];
      twice += a[x] * b[y] - a[y] * b[x];
    }
    return std::abs(twice) / 2;
  }
  double Low(int axis) const {
    double low = corners_[0][axis];
    for (std::size_t i = 1; i < count_; ++i) low = std::min(low, corners_[i][axis]);
    return low;
  }
  double High(int axis) const {
    double high = corners_[0][axis];
    for (std::size_t i = 1; i < count_; ++i) high = std::max(high, corners_[i][axis]);
    return high;
  }
  OnPanels Middle() const {
    OnPanels sum = OnPanels::Zero();
    for (std::size_t i = 0; i < count_; ++i) sum += corners_[i];
    return sum / static_cast<double>(count_);
  }

  // Keeps what is above `at` and returns what is below.
  Piece CutOff(int axis, double at) {
    Piece below, above;
    for (std::size_t i = 0; i < count_; ++i) {
      const OnPanels &from = corners_[i], &to = corners_[i + 1 < count_ ? i + 1 : 0];
      const double before = from[axis] - at, after = to[axis] - at;
      if (before <= 0) below.Add(from);
      if (before >= 0) above.Add(from);
      if (before * after < 0) {
        const OnPanels crossing = from + before / (before - after) * (to - from);
        below.Add(crossing);
        above.Add(crossing);
      }
    }
    *this = above;
    return below;
  }

 private:
  std::array<OnPanels, 16> corners_;
  std::size_t count_ = 0;
};

template <class Visit>
void CutPiece(Piece piece, std::span<const int> axes, const Visit& visit) {
  if (axes.empty()) return visit(piece);
  const int axis = axes[0];
  const double high = piece.High(axis);
  for (double at = std::floor(piece.Low(axis)) + 1; at < high; ++at) {
    CutPiece(piece.CutOff(axis, at), axes.subspan(1), visit);
  }
  CutPiece(piece, axes.subspan(1), visit);
}

// Strictly, in two of the coordinates; not where one is NaN.
bool IsConvex(const std::array<OnPanels, 4>& corners, int x, int y) {
  int left = 0, right = 0;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const OnPanels a = corners[(i + 1) % 4] - corners[i];
    const OnPanels b = corners[(i + 2) % 4] - corners[(i + 1) % 4];
    const double turn = a[x] * b[y] - a[y] * b[x];
    left += turn > 0;
    right += turn < 0;
  }
  return left == 4 || right == 4;
}

}  // namespace

bool CutPixel(const std::array<OnPanels, 4>& corners, const std::vector<int>& axes,
              const std::function<void(const OnPanels& within, double share)>& visit) {
  for (std::size_t i = 0; i < axes.size(); i += 2) {
    if (!IsConvex(corners, axes[i], axes[i + 1])) return false;
  }
  Piece whole;
  for (const OnPanels& corner : corners) whole.Add(corner);
  // A straight cut adds a piece and one for every cut of another axis that it crosses.
  double pieces = 1, cuts = 0;
  for (const int axis : axes) {
    const double more =
        std::max(0.0, std::ceil(whole.High(axis)) - std::floor(whole.Low(axis)) - 1);
    pieces += more * (1 + cuts);
    cuts += more;
  }
  if (!(pieces <= kMostPieces)) return false;
  const double area = whole.Area(axes[0], axes[1]);
  CutPiece(whole, axes, [&](const Piece& piece) {
    const double share = piece.Area(axes[0], axes[1]) / area;
    if (share > kLeastShare) visit(piece.Middle(), share);
  });
  return true;
}

}  // namespace lamella
