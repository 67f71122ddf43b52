// Pixels: a move-only Image that owns them and an ImageSpan that views a rectangle of them.
//
// Continuous coordinates: the first pixel's centre is (0.5, 0.5); an image spans [0,W] x [0,H].
#pragma once

#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "lightfield/large_pages.h"

namespace lamella {

// Linear light, Rec. 709 primaries.
struct Rgb {
  float r = 0, g = 0, b = 0;
  friend bool operator==(const Rgb&, const Rgb&) = default;
};
constexpr Rgb operator+(Rgb a, Rgb b) { return {a.r + b.r, a.g + b.g, a.b + b.b}; }
constexpr Rgb operator-(Rgb a, Rgb b) { return {a.r - b.r, a.g - b.g, a.b - b.b}; }
constexpr Rgb operator*(float s, Rgb a) { return {s * a.r, s * a.g, s * a.b}; }
constexpr Rgb& operator+=(Rgb& a, Rgb b) { return a = a + b; }

// sRGB-encoded, 8 bits a channel.
struct Rgb8 {
  std::uint8_t r = 0, g = 0, b = 0;
  friend bool operator==(const Rgb8&, const Rgb8&) = default;
};

struct Rect {
  int x = 0, y = 0, width = 0, height = 0;
  friend bool operator==(const Rect&, const Rect&) = default;
};

// A non-owning view; ImageSpan<const T> is read-only. Rows are `stride` elements apart.
template <class T>
struct ImageSpan {
  T* data = nullptr;
  int width = 0, height = 0;
  std::ptrdiff_t stride = 0;

  T& operator()(int x, int y) const { return data[y * stride + x]; }
  T* row(int y) const { return data + y * stride; }
  ImageSpan Sub(const Rect& r) const { return {&(*this)(r.x, r.y), r.width, r.height, stride}; }
  operator ImageSpan<const T>() const { return {data, width, height, stride}; }  // NOLINT
};

// Owns width x height pixels, rows contiguous. Copies are explicit (Clone), so none is made
// by accident.
template <class T>
class Image {
 public:
  Image() = default;
  Image(int width, int height, T fill = T())
      : width_(width),
        height_(height),
        pixels_(static_cast<std::size_t>(width) * static_cast<std::size_t>(height), fill) {}
  Image(Image&& other) noexcept
      : width_(std::exchange(other.width_, 0)),
        height_(std::exchange(other.height_, 0)),
        pixels_(std::move(other.pixels_)) {}
  Image& operator=(Image&& other) noexcept {
    width_ = std::exchange(other.width_, 0);
    height_ = std::exchange(other.height_, 0);
    pixels_ = std::move(other.pixels_);
    return *this;
  }
  Image Clone() const {
    Image copy;
    copy.width_ = width_;
    copy.height_ = height_;
    copy.pixels_ = pixels_;
    return copy;
  }

  int width() const { return width_; }
  int height() const { return height_; }
  bool empty() const { return pixels_.empty(); }
  std::size_t size() const { return pixels_.size(); }
  T* data() { return pixels_.data(); }
  const T* data() const { return pixels_.data(); }
  T& operator()(int x, int y) { return pixels_[Index(x, y)]; }
  const T& operator()(int x, int y) const { return pixels_[Index(x, y)]; }
  T* row(int y) { return pixels_.data() + Index(0, y); }
  const T* row(int y) const { return pixels_.data() + Index(0, y); }
  ImageSpan<T> span() { return {data(), width_, height_, width_}; }
  ImageSpan<const T> span() const { return {data(), width_, height_, width_}; }

 private:
  Image(const Image&) = delete;
  Image& operator=(const Image&) = delete;
  std::size_t Index(int x, int y) const {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(width_) +
           static_cast<std::size_t>(x);
  }
  int width_ = 0, height_ = 0;
  std::vector<T, PixelAllocator<T>> pixels_;
};

}  // namespace lamella
