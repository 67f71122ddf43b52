#include "datasets_synthetic/mesh_obj.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <limits>
#include <unordered_map>

#include <fmt/format.h>

#include "lightfield/error.h"

namespace lamella {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

std::string_view TakeWord(std::string_view* line) {
  const std::size_t first = std::min(line->find_first_not_of(" \t\r"), line->size());
  line->remove_prefix(first);
  const std::size_t length = std::min(line->find_first_of(" \t\r"), line->size());
  const std::string_view word = line->substr(0, length);
  line->remove_prefix(length);
  return word;
}

// A corner of a face: indices from 0 of vertex, texture coordinate, normal; -1: none.
using Corner = std::array<int, 3>;
struct CornerHash {
  std::size_t operator()(const Corner& c) const {
    std::uint64_t h = 0;
    for (const int i : c) h = (h ^ static_cast<std::uint32_t>(i)) * 0x9e3779b97f4a7c15U;
    return static_cast<std::size_t>(h ^ (h >> 32));
  }
};

class ObjParser {
 public:
  ObjParser(std::string_view text, const std::string& name) : rest_(text), name_(name) {}

  Mesh Parse() {
    while (!rest_.empty()) {
      ++line_;
      const std::size_t end = std::min(rest_.find('\n'), rest_.size());
      ParseLine(rest_.substr(0, end));
      rest_.remove_prefix(std::min(end + 1, rest_.size()));
    }
    CheckIndices();
    return needs_split_ ? Split() : Whole();
  }

 private:
  struct Greatest {  // index that was asked for, and where
    std::int64_t index = -1;
    int line = 0;
  };

  [[noreturn]] void Fail(int line, const std::string& what) const {
    throw InputError(fmt::format("{}:{}", name_, line), what, "repair the file");
  }

  void ParseLine(std::string_view line) {
    const std::string_view keyword = TakeWord(&line);
    if (keyword == "v") {
      vertices_.push_back(Numbers(&line));
    } else if (keyword == "vt") {
      const double u = Number(&line);
      std::string_view rest = line;
      texture_coordinates_.emplace_back(u, TakeWord(&rest).empty() ? 0 : Number(&line));
    } else if (keyword == "vn") {
      normals_.emplace_back(Numbers(&line).stableNormalized());
    } else if (keyword == "f") {
      ParseFace(line);
    }
  }

  Vector3d Numbers(std::string_view* line) const {
    Vector3d numbers;
    for (int i = 0; i < 3; ++i) numbers(i) = Number(line);
    return numbers;
  }

  double Number(std::string_view* line) const {
    const std::string_view word = TakeWord(line);
    if (word.empty()) Fail(line_, "a number is missing");
    const char* first = word.data() + (word[0] == '+' ? 1 : 0);
    const char* const last = word.data() + word.size();
    double value = 0;
    const auto [end, error] = std::from_chars(first, last, value);
    if (error == std::errc::result_out_of_range)
      Fail(line_, fmt::format("{} is out of range", word));
    if (error != std::errc() || end != last) Fail(line_, fmt::format("\"{}\" is no number", word));
    if (!std::isfinite(value)) Fail(line_, fmt::format("{} is not finite", word));
    return value;
  }

  void ParseFace(std::string_view line) {
    face_.clear();
    for (std::string_view word = TakeWord(&line); !word.empty() && word[0] != '#';
         word = TakeWord(&line)) {
      face_.push_back(ParseCorner(word));
    }
    if (face_.size() < 3) Fail(line_, fmt::format("a face of {} corners", face_.size()));
    for (std::size_t i = 2; i < face_.size(); ++i) {
      triangles_.push_back({face_[0], face_[i - 1], face_[i]});
    }
  }

  // v, v/vt, v//vn or v/vt/vn; from 1, or from -1 backwards.
  Corner ParseCorner(std::string_view word) {
    const std::array<std::size_t, 3> counts = {vertices_.size(), texture_coordinates_.size(),
                                               normals_.size()};
    Corner corner = {-1, -1, -1};
    std::string_view rest = word;
    for (std::size_t kind = 0; kind < 3; ++kind) {
      const std::size_t length = std::min(rest.find('/'), rest.size());
      if (length > 0) {
        corner[kind] = Index(rest.substr(0, length), counts[kind], kind);
        needs_split_ |= kind > 0;
      } else if (kind != 1) {
        Fail(line_, fmt::format("\"{}\" is no corner of a face", word));
      }
      if (length == rest.size()) return corner;
      rest.remove_prefix(length + 1);
    }
    Fail(line_, fmt::format("\"{}\" is no corner of a face", word));
  }

  int Index(std::string_view word, std::size_t count, std::size_t kind) {
    std::int64_t index = 0;
    const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), index);
    if (error != std::errc() || end != word.data() + word.size()) {
      Fail(line_, fmt::format("\"{}\" is no index", word));
    }
    const std::int64_t from_zero = index < 0 ? static_cast<std::int64_t>(count) + index : index - 1;
    if (index == 0 || from_zero < 0 || from_zero >= std::numeric_limits<int>::max()) {
      Fail(line_, fmt::format("index {} is out of range: there are {}", index, count));
    }
    // A face may come before its vertices: whether they come is known at the end.
    if (from_zero > greatest_[kind].index) greatest_[kind] = {from_zero, line_};
    return static_cast<int>(from_zero);
  }

  void CheckIndices() const {
    const std::array<std::size_t, 3> counts = {vertices_.size(), texture_coordinates_.size(),
                                               normals_.size()};
    for (std::size_t kind = 0; kind < 3; ++kind) {
      if (greatest_[kind].index < static_cast<std::int64_t>(counts[kind])) continue;
      Fail(greatest_[kind].line, fmt::format("index {} is out of range: there are {}",
                                             greatest_[kind].index + 1, counts[kind]));
    }
  }

  Mesh Whole() {
    Mesh mesh;
    mesh.vertices = std::move(vertices_);
    mesh.triangles.reserve(triangles_.size());
    for (const auto& t : triangles_) mesh.triangles.emplace_back(t[0][0], t[1][0], t[2][0]);
    return mesh;
  }

  Mesh Split() {
    Mesh mesh;
    std::unordered_map<Corner, int, CornerHash> vertex_of;
    const auto vertex = [&](const Corner& corner) {
      const auto [found, is_new] =
          vertex_of.try_emplace(corner, static_cast<int>(mesh.vertices.size()));
      if (!is_new) return found->second;
      const auto at = [&](std::size_t kind) { return static_cast<std::size_t>(corner[kind]); };
      mesh.vertices.push_back(vertices_[at(0)]);
      if (!texture_coordinates_.empty()) {
        mesh.texture_coordinates.push_back(corner[1] < 0 ? Vector2d(0, 0)
                                                         : texture_coordinates_[at(1)]);
      }
      if (!normals_.empty()) {
        mesh.normals.push_back(corner[2] < 0 ? Vector3d(0, 0, 0) : normals_[at(2)]);
      }
      return found->second;
    };
    mesh.triangles.reserve(triangles_.size());
    for (const auto& t : triangles_) {
      const int a = vertex(t[0]), b = vertex(t[1]), c = vertex(t[2]);
      mesh.triangles.emplace_back(a, b, c);
    }
    return mesh;
  }

  std::string_view rest_;
  std::string name_;
  int line_ = 0;
  std::vector<Vector3d> vertices_, normals_;
  std::vector<Vector2d> texture_coordinates_;
  std::vector<Corner> face_;
  std::vector<std::array<Corner, 3>> triangles_;
  std::array<Greatest, 3> greatest_;
  bool needs_split_ = false;  // texture coordinates or normals are used
};

}  // namespace

Mesh ParseObj(std::string_view text, const std::string& name) {
  return ObjParser(text, name).Parse();
}

}  // namespace lamella
