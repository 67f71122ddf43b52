#include "pipeline/poses/model.h"

#include <cmath>
#include <cstring>
#include <sstream>

#include <fmt/format.h>

#include "lightfield/atomic_file.h"
#include "lightfield/error.h"

namespace lamella {
namespace fs = std::filesystem;
namespace {

constexpr const char* kReplace = "replace the model's files";

Error Broken(const fs::path& file, const std::string& what) {
  return InputError(file.string(), what, kReplace);
}

Eigen::Quaterniond CheckedQuaternion(double w, double x, double y, double z, const fs::path& file) {
  const Eigen::Quaterniond q(w, x, y, z);
  if (!q.coeffs().allFinite() || q.norm() < 1e-6) {
    throw Broken(file, "has an image whose rotation is no quaternion");
  }
  return q.normalized();
}

// ---- binary ----

class Bytes {
 public:
  explicit Bytes(const fs::path& file) : file_(file), bytes_(ReadText(file)) {}
  template <class T>
  T Take() {
    Need(sizeof(T));
    T value;
    std::memcpy(&value, bytes_.data() + at_, sizeof(T));
    at_ += sizeof(T);
    return value;
  }
  std::string TakeName() {
    const std::size_t end = bytes_.find('\0', at_);
    if (end == std::string::npos) throw Broken(file_, "is truncated");
    std::string name = bytes_.substr(at_, end - at_);
    at_ = end + 1;
    return name;
  }
  // A count of records of at least `size` bytes: what the file can't hold is refused before memory
  // is taken for it.
  std::size_t TakeCount(std::size_t size) {
    const auto count = Take<std::uint64_t>();
    if (count > (bytes_.size() - at_) / size) throw Broken(file_, "is truncated");
    return static_cast<std::size_t>(count);
  }
  Eigen::Vector3d TakeVector() {
    const double x = Take<double>(), y = Take<double>(), z = Take<double>();
    if (!std::isfinite(x + y + z)) throw Broken(file_, "has a position that is not finite");
    return {x, y, z};
  }
  const fs::path& file() const { return file_; }

 private:
  void Need(std::size_t size) const {
    if (bytes_.size() - at_ < size) throw Broken(file_, "is truncated");
  }
  fs::path file_;
  std::string bytes_;
  std::size_t at_ = 0;
};

int ParameterCount(int model_id) {
  constexpr int kCounts[] = {3, 4, 4, 5, 8, 8, 12, 5, 4, 5, 12};
  return model_id >= 0 && model_id <= 10 ? kCounts[model_id] : 0;
}

void ReadCamerasBinary(const fs::path& file, ColmapModel& model) {
  Bytes bytes(file);
  for (std::size_t n = bytes.TakeCount(24); n > 0; --n) {
    const auto id = bytes.Take<std::uint32_t>();
    const auto model_id = bytes.Take<std::int32_t>();
    const auto width = bytes.Take<std::uint64_t>(), height = bytes.Take<std::uint64_t>();
    if (std::max(width, height) > (1U << 20)) throw Broken(file, "has a camera of absurd size");
    std::vector<double> parameters(static_cast<std::size_t>(ParameterCount(model_id)));
    for (double& parameter : parameters) parameter = bytes.Take<double>();
    model.cameras[id] = FromColmap(model_id, static_cast<int>(width), static_cast<int>(height),
                                   parameters, file.string());
  }
}

void ReadImagesBinary(const fs::path& file, ColmapModel& model) {
  Bytes bytes(file);
  for (std::size_t n = bytes.TakeCount(73); n > 0; --n) {
    ColmapImage image;
    image.id = bytes.Take<std::uint32_t>();
    double q[4];
    for (double& element : q) element = bytes.Take<double>();
    image.camera_from_world.rotation = CheckedQuaternion(q[0], q[1], q[2], q[3], file);
    image.camera_from_world.translation = bytes.TakeVector();
    image.camera_id = bytes.Take<std::uint32_t>();
    image.name = bytes.TakeName();
    image.observations.resize(bytes.TakeCount(24));
    for (ColmapObservation& o : image.observations) {
      o.pixel.x() = bytes.Take<double>();
      o.pixel.y() = bytes.Take<double>();
      o.point_id = static_cast<std::int64_t>(bytes.Take<std::uint64_t>());
    }
    model.images[image.id] = std::move(image);
  }
}

void ReadPointsBinary(const fs::path& file, ColmapModel& model) {
  Bytes bytes(file);
  for (std::size_t n = bytes.TakeCount(51); n > 0; --n) {
    const auto id = static_cast<std::int64_t>(bytes.Take<std::uint64_t>());
    ColmapPoint point;
    point.position = bytes.TakeVector();
    point.color.r = bytes.Take<std::uint8_t>();
    point.color.g = bytes.Take<std::uint8_t>();
    point.color.b = bytes.Take<std::uint8_t>();
    point.error_px = bytes.Take<double>();
    point.track.resize(bytes.TakeCount(8));
    for (ColmapTrackElement& element : point.track) {
      element.image_id = bytes.Take<std::uint32_t>();
      element.observation = bytes.Take<std::uint32_t>();
    }
    model.points[id] = std::move(point);
  }
}

// ---- text ----

// The lines that are no comment. Some programs separate the numbers of images.txt by ", ".
class Lines {
 public:
  explicit Lines(const fs::path& file) : file_(file), text_(ReadText(file)) {}
  bool Next() {
    std::string line;
    while (std::getline(text_, line)) {
      ++number_;
      if (!line.empty() && line[0] == '#') continue;
      for (char& c : line) {
        if (c == ',' || c == '\r') c = ' ';
      }
      line_ = std::istringstream(line);
      return true;
    }
    return false;
  }
  bool NextNotBlank() {
    while (Next()) {
      if (!AtEnd()) return true;
    }
    return false;
  }
  template <class T>
  T Take() {
    T value{};
    if (!(line_ >> value)) {
      throw InputError(fmt::format("{}:{}", file_.string(), number_), "can't be understood",
                       kReplace);
    }
    return value;
  }
  Eigen::Vector3d TakeVector() {
    const double x = Take<double>(), y = Take<double>(), z = Take<double>();
    return {x, y, z};
  }
  bool AtEnd() { return (line_ >> std::ws).eof(); }

 private:
  fs::path file_;
  std::istringstream text_;
  std::istringstream line_;
  int number_ = 0;
};

void ReadCamerasText(const fs::path& file, ColmapModel& model) {
  Lines lines(file);
  while (lines.NextNotBlank()) {
    const auto id = lines.Take<std::uint32_t>();
    const auto name = lines.Take<std::string>();
    const int width = lines.Take<int>(), height = lines.Take<int>();
    std::vector<double> parameters;
    while (!lines.AtEnd()) parameters.push_back(lines.Take<double>());
    const int model_id = ColmapModelId(name);
    if (model_id < 0) throw Broken(file, "has a camera of the model " + name + ", unknown here");
    model.cameras[id] = FromColmap(model_id, width, height, parameters, file.string());
  }
}

void ReadImagesText(const fs::path& file, ColmapModel& model) {
  Lines lines(file);
  while (lines.NextNotBlank()) {
    ColmapImage image;
    image.id = lines.Take<std::uint32_t>();
    double q[4];
    for (double& element : q) element = lines.Take<double>();
    image.camera_from_world.rotation = CheckedQuaternion(q[0], q[1], q[2], q[3], file);
    image.camera_from_world.translation = lines.TakeVector();
    image.camera_id = lines.Take<std::uint32_t>();
    image.name = lines.Take<std::string>();
    if (lines.Next()) {
      while (!lines.AtEnd()) {
        ColmapObservation o;
        o.pixel.x() = lines.Take<double>();
        o.pixel.y() = lines.Take<double>();
        o.point_id = lines.Take<std::int64_t>();
        image.observations.push_back(o);
      }
    }
    model.images[image.id] = std::move(image);
  }
}

void ReadPointsText(const fs::path& file, ColmapModel& model) {
  Lines lines(file);
  while (lines.NextNotBlank()) {
    const auto id = lines.Take<std::int64_t>();
    ColmapPoint point;
    point.position = lines.TakeVector();
    const auto color = [&] { return static_cast<std::uint8_t>(lines.Take<int>()); };
    point.color.r = color();
    point.color.g = color();
    point.color.b = color();
    point.error_px = lines.Take<double>();
    while (!lines.AtEnd()) {
      const auto image_id = lines.Take<std::uint32_t>();
      point.track.push_back({image_id, lines.Take<std::uint32_t>()});
    }
    model.points[id] = std::move(point);
  }
}

bool HasAll(const fs::path& folder, const std::string& extension) {
  return fs::is_regular_file(folder / ("cameras" + extension)) &&
         fs::is_regular_file(folder / ("images" + extension)) &&
         fs::is_regular_file(folder / ("points3D" + extension));
}

void CheckReferences(const fs::path& folder, const ColmapModel& model) {
  for (const auto& [id, image] : model.images) {
    if (!model.cameras.contains(image.camera_id)) {
      throw Broken(folder, fmt::format("image {} has no camera {}", image.name, image.camera_id));
    }
  }
  for (const auto& [id, point] : model.points) {
    for (const ColmapTrackElement& element : point.track) {
      const auto image = model.images.find(element.image_id);
      if (image == model.images.end() || element.observation >= image->second.observations.size()) {
        throw Broken(folder, fmt::format("point {} is seen by no such image", id));
      }
    }
  }
}

}  // namespace

bool IsColmapModel(const fs::path& folder) {
  return HasAll(folder, ".bin") || HasAll(folder, ".txt");
}

ColmapModel ReadColmapModel(const fs::path& folder) {
  ColmapModel model;
  if (HasAll(folder, ".bin")) {
    ReadCamerasBinary(folder / "cameras.bin", model);
    ReadImagesBinary(folder / "images.bin", model);
    ReadPointsBinary(folder / "points3D.bin", model);
  } else {
    ReadCamerasText(folder / "cameras.txt", model);
    ReadImagesText(folder / "images.txt", model);
    ReadPointsText(folder / "points3D.txt", model);
  }
  CheckReferences(folder, model);
  return model;
}

void WriteColmapModel(const fs::path& folder, const ColmapModel& model) {
  std::string cameras = "# CAMERA_ID, MODEL, WIDTH, HEIGHT, PARAMS[]\n";
  for (const auto& [id, camera] : model.cameras) {
    const ColmapCamera colmap = ToColmap(camera);
    cameras += fmt::format("{} {} {} {} {}\n", id, colmap.model, camera.width, camera.height,
                           fmt::join(colmap.parameters, " "));
  }
  std::string images =
      "# IMAGE_ID, QW, QX, QY, QZ, TX, TY, TZ, CAMERA_ID, NAME\n"
      "# POINTS2D[] as (X, Y, POINT3D_ID)\n";
  for (const auto& [id, image] : model.images) {
    const Eigen::Quaterniond& q = image.camera_from_world.rotation;
    const Eigen::Vector3d& t = image.camera_from_world.translation;
    images += fmt::format("{} {} {} {} {} {} {} {} {} {}\n", id, q.w(), q.x(), q.y(), q.z(), t.x(),
                          t.y(), t.z(), image.camera_id, image.name);
    const char* separator = "";
    for (const ColmapObservation& o : image.observations) {
      images += fmt::format("{}{} {} {}", separator, o.pixel.x(), o.pixel.y(), o.point_id);
      separator = " ";
    }
    images += '\n';
  }
  std::string points =
      "# POINT3D_ID, X, Y, Z, R, G, B, ERROR, TRACK[] as (IMAGE_ID, POINT2D_IDX)\n";
  for (const auto& [id, point] : model.points) {
    const Eigen::Vector3d& p = point.position;
    points += fmt::format("{} {} {} {} {} {} {} {}", id, p.x(), p.y(), p.z(), point.color.r,
                          point.color.g, point.color.b, point.error_px);
    for (const ColmapTrackElement& element : point.track) {
      points += fmt::format(" {} {}", element.image_id, element.observation);
    }
    points += '\n';
  }
  CreateFolder(folder);
  WriteTextAtomically(folder / "cameras.txt", cameras);
  WriteTextAtomically(folder / "images.txt", images);
  WriteTextAtomically(folder / "points3D.txt", points);
}

std::vector<View> ViewsOf(const ColmapModel& model) {
  std::vector<View> views;
  for (const auto& [id, image] : model.images) {
    View view;
    view.name = fs::path(image.name).stem().string();
    view.camera = model.cameras.at(image.camera_id);
    view.camera_from_world = image.camera_from_world;
    views.push_back(std::move(view));
  }
  return views;
}

double ReprojectionErrorPx(const ColmapModel& model) {
  double sum = 0;
  std::int64_t count = 0;
  for (const auto& [id, point] : model.points) {
    for (const ColmapTrackElement& element : point.track) {
      const ColmapImage& image = model.images.at(element.image_id);
      const auto pixel =
          Project(model.cameras.at(image.camera_id), image.camera_from_world * point.position);
      if (!pixel) continue;
      sum += (*pixel - image.observations[element.observation].pixel).squaredNorm();
      ++count;
    }
  }
  return count > 0 ? std::sqrt(sum / static_cast<double>(count)) : 0;
}

}  // namespace lamella
