// Numbers that carry their derivatives by N parameters (forward-mode automatic differentiation), so
// that a formula written once gives a value with `double` and a row of a Jacobian with Dual<N>.
#pragma once

#include <cmath>

#include <Eigen/Core>

namespace lamella {

template <int N>
struct Dual {
  using Derivatives = Eigen::Array<double, N, 1>;
  double value = 0;
  Derivatives d = Derivatives::Zero();

  Dual() = default;
  Dual(double constant) : value(constant) {}  // NOLINT: numbers are duals without derivatives
  Dual(double v, const Derivatives& derivatives) : value(v), d(derivatives) {}
  // The parameter itself, of which this is the column.
  static Dual Variable(double value, int column) {
    Dual x(value);
    x.d(column) = 1;
    return x;
  }

  Dual& operator+=(const Dual& b) {
    value += b.value;
    d += b.d;
    return *this;
  }
  Dual& operator-=(const Dual& b) {
    value -= b.value;
    d -= b.d;
    return *this;
  }
  Dual& operator*=(const Dual& b) { return *this = *this * b; }
  Dual& operator/=(const Dual& b) { return *this = *this / b; }

  friend Dual operator+(const Dual& a, const Dual& b) { return {a.value + b.value, a.d + b.d}; }
  friend Dual operator-(const Dual& a, const Dual& b) { return {a.value - b.value, a.d - b.d}; }
  friend Dual operator-(const Dual& a) { return {-a.value, -a.d}; }
  friend Dual operator*(const Dual& a, const Dual& b) {
    return {a.value * b.value, a.value * b.d + b.value * a.d};
  }
  friend Dual operator/(const Dual& a, const Dual& b) {
    const double inverse = 1 / b.value, quotient = a.value * inverse;
    return {quotient, inverse * (a.d - quotient * b.d)};
  }
  // Constants have no derivatives to carry.
  friend Dual operator+(const Dual& a, double b) { return {a.value + b, a.d}; }
  friend Dual operator+(double a, const Dual& b) { return {a + b.value, b.d}; }
  friend Dual operator-(const Dual& a, double b) { return {a.value - b, a.d}; }
  friend Dual operator-(double a, const Dual& b) { return {a - b.value, -b.d}; }
  friend Dual operator*(const Dual& a, double b) { return {a.value * b, a.d * b}; }
  friend Dual operator*(double a, const Dual& b) { return {a * b.value, a * b.d}; }
  friend Dual operator/(const Dual& a, double b) { return {a.value / b, a.d * (1 / b)}; }

  friend bool operator<(const Dual& a, const Dual& b) { return a.value < b.value; }
  friend bool operator>(const Dual& a, const Dual& b) { return a.value > b.value; }

  friend Dual sqrt(const Dual& a) {
    const double root = std::sqrt(a.value);
    return {root, a.d * (0.5 / root)};
  }
  friend Dual sin(const Dual& a) { return {std::sin(a.value), a.d * std::cos(a.value)}; }
  friend Dual cos(const Dual& a) { return {std::cos(a.value), a.d * -std::sin(a.value)}; }
};

inline double ValueOf(double x) { return x; }
template <int N>
double ValueOf(const Dual<N>& x) {
  return x.value;
}

}  // namespace lamella

namespace Eigen {
template <int N>
struct NumTraits<lamella::Dual<N>> : NumTraits<double> {
  using Real = lamella::Dual<N>;
  using NonInteger = lamella::Dual<N>;
  using Nested = lamella::Dual<N>;
  enum { IsComplex = 0, IsInteger = 0, IsSigned = 1, RequireInitialization = 1 };
};
}  // namespace Eigen
