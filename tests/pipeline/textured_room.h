// Pictures of a textured room, ray by ray: photographs whose cameras are known exactly.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "lightfield/camera.h"
#include "lightfield/image.h"
#include "lightfield/rigid.h"

namespace lamella {

// What the camera sees of a floor, a back wall and a box with an irregular texture; `seed` changes
// the texture. World: x right, y down, z forward, units about metres; the box stands 4 in front of
// the origin.
Image<Rgb> PhotographRoom(const Camera& camera, const Rigid& camera_from_world, unsigned seed = 1);

// The distance of a point from the nearest surface.
double DistanceFromRoom(const Eigen::Vector3d& point);

// `count` cameras along an arc, all looking at the box.
std::vector<Rigid> ArcOfCameras(int count);

}  // namespace lamella
