#include "datasets_synthetic/room.h"

#include <numbers>

namespace lamella {
namespace {

using Eigen::Vector3d;
using Pattern = Texture::Pattern;

class RoomBuilder {
 public:
  explicit RoomBuilder(std::uint32_t seed) : seed_(seed) {}

  void Add(const Shape& shape, const Texture& texture) {
    scene_.surfaces.push_back({shape, texture});
  }
  void AddBox(const Vector3d& centre, const Vector3d& size, double turn_deg,
              const Texture& texture) {
    const Eigen::Quaterniond turn(
        Eigen::AngleAxisd(turn_deg * std::numbers::pi / 180, Vector3d::UnitY()));
    for (const Shape& face : Box(centre, size, turn)) Add(face, texture);
  }
  // Each texture has noise of its own.
  Texture Make(Pattern pattern, double scale, Rgb dark, Rgb light, Rgb accent) {
    return {.pattern = pattern,
            .seed = seed_ * 1000 + ++count_,
            .scale = scale,
            .octaves = 8,
            .dark = dark,
            .light = light,
            .accent = accent};
  }
  Scene& scene() { return scene_; }

 private:
  std::uint32_t seed_, count_ = 0;
  Scene scene_;
};

void AddWalls(RoomBuilder& room) {
  const double floor = -1, back = -2.4, left = -2.6;
  room.Add(Parallelogram{{left, floor, back}, {6.5, 0, 0}, {0, 0, 6}},
           room.Make(Pattern::kTiles, 0.45, {0.30F, 0.16F, 0.08F}, {0.72F, 0.62F, 0.48F},
                     {0.50F, 0.30F, 0.16F}));
  room.Add(Parallelogram{{left, floor, back}, {6.5, 0, 0}, {0, 4.5, 0}},
           room.Make(Pattern::kNoise, 0.7, {0.36F, 0.42F, 0.46F}, {0.86F, 0.88F, 0.84F},
                     {0.30F, 0.48F, 0.52F}));
  room.Add(Parallelogram{{left, floor, back}, {0, 0, 6}, {0, 4.5, 0}},
           room.Make(Pattern::kNoise, 0.6, {0.52F, 0.40F, 0.20F}, {0.90F, 0.80F, 0.56F},
                     {0.40F, 0.22F, 0.10F}));
  // A picture on the back wall, with a frame.
  room.AddBox({0.35, 0.55, -2.37}, {1.5, 1.0, 0.06}, 0,
              room.Make(Pattern::kNoise, 0.2, {0.08F, 0.05F, 0.03F}, {0.30F, 0.20F, 0.10F},
                        {0.5F, 0.38F, 0.2F}));
  room.Add(Parallelogram{{-0.30, 0.15, -2.33}, {1.3, 0, 0}, {0, 0.8, 0}},
           room.Make(Pattern::kSpots, 0.35, {0.04F, 0.10F, 0.30F}, {0.30F, 0.60F, 0.75F},
                     {0.95F, 0.75F, 0.20F}));
}

void AddThings(RoomBuilder& room) {
  room.AddBox({-1.15, -0.55, -1.25}, {0.8, 0.9, 0.7}, 24,
              room.Make(Pattern::kNoise, 0.4, {0.35F, 0.05F, 0.04F}, {0.85F, 0.30F, 0.16F},
                        {0.95F, 0.85F, 0.55F}));
  room.Add(Sphere{{-1.15, 0.20, -1.25}, 0.30},
           room.Make(Pattern::kSpots, 0.30, {0.08F, 0.25F, 0.10F}, {0.40F, 0.70F, 0.25F},
                     {0.95F, 0.95F, 0.75F}));
  room.AddBox({1.35, -0.35, -1.05}, {0.55, 1.3, 0.55}, -18,
              room.Make(Pattern::kSpots, 0.35, {0.10F, 0.10F, 0.35F}, {0.40F, 0.45F, 0.80F},
                        {0.95F, 0.92F, 0.85F}));
  room.AddBox({0.30, -0.80, -0.30}, {0.9, 0.4, 0.5}, 35,
              room.Make(Pattern::kTiles, 0.13, {0.10F, 0.30F, 0.28F}, {0.80F, 0.75F, 0.60F},
                        {0.75F, 0.30F, 0.12F}));
  room.Add(Sphere{{0.28, -0.30, -0.30}, 0.30},
           room.Make(Pattern::kNoise, 0.25, {0.45F, 0.25F, 0.05F}, {0.95F, 0.75F, 0.25F},
                     {0.45F, 0.05F, 0.10F}));
  room.Add(Sphere{{-0.62, -0.74, 0.35}, 0.26},
           room.Make(Pattern::kNoise, 0.22, {0.25F, 0.08F, 0.30F}, {0.80F, 0.55F, 0.85F},
                     {0.95F, 0.95F, 0.90F}));
  room.Add(Sphere{{1.05, -0.80, 0.45}, 0.20},
           room.Make(Pattern::kSpots, 0.22, {0.40F, 0.40F, 0.42F}, {0.90F, 0.90F, 0.88F},
                     {0.75F, 0.10F, 0.08F}));
  room.AddBox({-1.75, -0.1, -2.0}, {0.12, 1.8, 0.12}, 10,
              room.Make(Pattern::kNoise, 0.15, {0.12F, 0.07F, 0.04F}, {0.55F, 0.38F, 0.20F},
                        {0.8F, 0.7F, 0.5F}));
}

}  // namespace

Scene Room(std::uint32_t seed) {
  RoomBuilder room(seed);
  AddWalls(room);
  AddThings(room);
  room.scene().lighting = {.lamp = {2.2, 4.0, 4.5}, .lamp_strength = 0.62F, .ambient = 0.36F};
  room.scene().background = {0.05F, 0.06F, 0.08F};
  return std::move(room.scene());
}

HandheldArc ArcBeforeRoom() {
  HandheldArc arc;
  arc.target = {0.05, -0.25, -0.8};
  arc.radius = 3.7;
  arc.height = 0.75;
  arc.angle_deg = 30;
  arc.place_jitter = 0.012;
  return arc;
}

}  // namespace lamella
