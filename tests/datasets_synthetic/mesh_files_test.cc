// Meshes from files: written out here, whole and damaged.
#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "datasets_synthetic/mesh.h"
#include "lightfield/error.h"
#include "tests/scratch.h"

namespace lamella {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using Eigen::Vector3i;
using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;

class MeshFile : public testing::Test {
 protected:
  std::filesystem::path Write(const std::string& name, const std::string& bytes) const {
    std::filesystem::path path = scratch_ / name;
    std::ofstream(path, std::ios::binary) << bytes;
    return path;
  }
  Mesh Read(const std::string& name, const std::string& bytes) const {
    return ReadMesh(Write(name, bytes));
  }
  // The one line that refuses the file.
  std::string Complaint(const std::string& name, const std::string& bytes) const {
    try {
      Read(name, bytes);
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ExitCode::kInput);
      return error.what();
    }
    return "was read";
  }

 private:
  std::filesystem::path scratch_ = ScratchFolder();
};

TEST_F(MeshFile, ObjWithPolygonsNegativeIndicesAndOtherLines) {
  const Mesh mesh = Read("a.obj",
                         "# a roof\r\nmtllib x.mtl\no roof\nv 0 0 0\nv 1 0 0\nv +1 1 0 1.0\n"
                         "v 0 1e0 0\ns off\nf 1 2 3 4 # a square\nv 0.5 .5 1\nf -1 -2 1\n");
  ASSERT_EQ(mesh.vertices.size(), 5U);
  EXPECT_EQ(mesh.vertices[4], Vector3d(0.5, 0.5, 1));
  EXPECT_THAT(mesh.triangles, ElementsAre(Vector3i(0, 1, 2), Vector3i(0, 2, 3), Vector3i(4, 3, 0)));
  EXPECT_TRUE(mesh.texture_coordinates.empty() && mesh.normals.empty());
}

TEST_F(MeshFile, ObjSplitsVerticesWithSeveralTextureCoordinates) {
  const Mesh mesh = Read("a.obj",
                         "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0.5\n"
                         "vn 0 0 2\nf 1/1/1 2/2/1 3/3/1\nf 1/4/1 3/3/1 4//1\n");
  EXPECT_THAT(mesh.triangles, ElementsAre(Vector3i(0, 1, 2), Vector3i(3, 2, 4)));
  ASSERT_EQ(mesh.texture_coordinates.size(), 5U);
  EXPECT_EQ(mesh.vertices[3], mesh.vertices[0]);
  EXPECT_EQ(mesh.texture_coordinates[2], Vector2d(1, 1));
  EXPECT_EQ(mesh.texture_coordinates[3], Vector2d(0.5, 0));
  EXPECT_EQ(mesh.normals[4], Vector3d(0, 0, 1));
}

TEST_F(MeshFile, ObjIsRefusedWithLineAndReason) {
  const auto complaint = [&](const std::string& text) { return Complaint("bad.obj", text); };
  EXPECT_THAT(complaint("v 0 0 0\nv 0 nan 0\n"),
              AllOf(HasSubstr("bad.obj:2: "), HasSubstr("not finite")));
  EXPECT_THAT(complaint("v 0 0 1e999\n"), AllOf(HasSubstr("bad.obj:1: "), HasSubstr("range")));
  EXPECT_THAT(complaint("v 0 0\n"), AllOf(HasSubstr("bad.obj:1: "), HasSubstr("missing")));
  EXPECT_THAT(complaint("v 0 zero 0\n"), AllOf(HasSubstr("bad.obj:1: "), HasSubstr("zero")));
  const std::string corners = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
  EXPECT_THAT(complaint(corners + "f 1 2 4\nv 1 1 1 \nf 1 2 7\n"),
              AllOf(HasSubstr("bad.obj:6: "), HasSubstr("index 7")));
  EXPECT_THAT(complaint(corners + "f 1 2 -4\n"), HasSubstr("bad.obj:4: index -4"));
  EXPECT_THAT(complaint(corners + "f 0 1 2\n"), HasSubstr("bad.obj:4: index 0"));
  EXPECT_THAT(complaint(corners + "f 1 2 99999999999999999999\n"), HasSubstr("bad.obj:4: "));
  EXPECT_THAT(complaint(corners + "f 1/1 2/1 3/1\n"), HasSubstr("bad.obj:4: "));
  EXPECT_THAT(complaint(corners + "f 1 2\n"), HasSubstr("bad.obj:4: a face of 2 corners"));
  EXPECT_THAT(complaint(corners + "f 1 2 //3\n"), HasSubstr("bad.obj:4: "));
  EXPECT_THAT(complaint(corners + "f 1/1/1/1 2 3\n"), HasSubstr("bad.obj:4: "));
  EXPECT_THAT(Complaint("bad.stl", corners), HasSubstr("\".stl\" is no known format"));
  EXPECT_THROW(ReadMesh("/nowhere/at/all.obj"), Error);
}

TEST_F(MeshFile, EmptyMeshesAreMeshes) {
  EXPECT_TRUE(Read("a.obj", "").triangles.empty());
  EXPECT_TRUE(Read("a.ply",
                   "ply\nformat ascii 1.0\nelement vertex 0\nproperty float x\nproperty float y\n"
                   "property float z\nelement face 0\nproperty list uchar int vertex_index\n"
                   "end_header\n")
                  .triangles.empty());
}

std::string PlyHeader(const std::string& format, int vertices, int faces) {
  return "ply\nformat " + format + " 1.0\ncomment made here\nelement vertex " +
         std::to_string(vertices) +
         "\nproperty float x\nproperty double y\nproperty float z\nproperty uchar red\n"
         "property float s\nproperty float t\nelement edge 1\nproperty list uchar short vertices\n"
         "element face " +
         std::to_string(faces) +
         "\nproperty list uchar int vertex_indices\nproperty char quality\nend_header\n";
}

template <class T>
void Put(T value, bool big, std::string* bytes) {
  char raw[sizeof(T)];
  std::memcpy(raw, &value, sizeof(T));
  if (big != (std::endian::native == std::endian::big)) std::reverse(raw, raw + sizeof(T));
  bytes->append(raw, sizeof(T));
}

std::string BinaryPly(bool big, float last_x = 0.25F, int last_index = 3) {
  std::string bytes = PlyHeader(big ? "binary_big_endian" : "binary_little_endian", 4, 2);
  for (int i = 0; i < 4; ++i) {
    Put<float>(i == 3 ? last_x : static_cast<float>(i), big, &bytes);
    Put<double>(0.1 * i, big, &bytes);
    Put<float>(-1, big, &bytes);
    Put<std::uint8_t>(200, big, &bytes);
    Put<float>(0.5F, big, &bytes);
    Put<float>(0.25F * static_cast<float>(i), big, &bytes);
  }
  Put<std::uint8_t>(2, big, &bytes);  // an edge
  Put<std::int16_t>(0, big, &bytes);
  Put<std::int16_t>(1, big, &bytes);
  for (const std::vector<int>& face : {std::vector<int>{0, 1, 2}, {0, 1, 2, last_index}}) {
    Put<std::uint8_t>(static_cast<std::uint8_t>(face.size()), big, &bytes);
    for (const int index : face) Put<std::int32_t>(index, big, &bytes);
    Put<std::int8_t>(-7, big, &bytes);
  }
  return bytes;
}

TEST_F(MeshFile, PlyInThreeEncodingsIsTheSameMesh) {
  const std::string ascii = PlyHeader("ascii", 4, 2) +
                            "0 0 -1 200 0.5 0\n1 0.1 -1 200 0.5 0.25\n2 0.2 -1 200 0.5 0.5\n"
                            "0.25 0.30000000000000004 -1 200 0.5 0.75\n2 0 1\n"
                            "3 0 1 2 -7\n4 0 1 2 3 -7\n";
  for (const std::string& bytes : {ascii, BinaryPly(false), BinaryPly(true)}) {
    const Mesh mesh = Read("a.PLY", bytes);
    ASSERT_EQ(mesh.vertices.size(), 4U);
    EXPECT_EQ(mesh.vertices[3], Vector3d(0.25, 0.1 * 3, -1));
    EXPECT_EQ(mesh.texture_coordinates[3], Vector2d(0.5, 0.75));
    EXPECT_TRUE(mesh.normals.empty());
    EXPECT_THAT(mesh.triangles,
                ElementsAre(Vector3i(0, 1, 2), Vector3i(0, 1, 2), Vector3i(0, 2, 3)));
  }
}

TEST_F(MeshFile, PlyIsRefusedWithPlaceAndReason) {
  const auto complaint = [&](const std::string& text) { return Complaint("bad.ply", text); };
  EXPECT_THAT(complaint(""), HasSubstr("no PLY file"));
  EXPECT_THAT(complaint("solid\n"), HasSubstr("bad.ply:1: no PLY file"));
  EXPECT_THAT(complaint("ply\nformat ascii 1.0\n"), HasSubstr("end_header"));
  EXPECT_THAT(complaint("ply\nformat utf8 1.0\n"), HasSubstr("bad.ply:2: there is no format"));
  EXPECT_THAT(complaint("ply\nformat ascii 1.0\nelement vertex many\n"), HasSubstr("bad.ply:3: "));
  EXPECT_THAT(complaint("ply\nformat ascii 1.0\nelement vertex 1\nproperty real x\n"),
              HasSubstr("bad.ply:4: there is no type \"real\""));
  EXPECT_THAT(complaint("ply\nformat ascii 1.0\nend_header\n"), HasSubstr("\"vertex\""));
  EXPECT_THAT(complaint(PlyHeader("ascii", 1, 0) + "nan 0 0 0 0 0\n2 0 0\n"),
              AllOf(HasSubstr("bad.ply:17: "), HasSubstr("not finite")));
  EXPECT_THAT(complaint(PlyHeader("ascii", 1, 0) + "0 0 zero 0 0 0\n2 0 0\n"),
              AllOf(HasSubstr("bad.ply:17: "), HasSubstr("zero")));
  EXPECT_THAT(complaint(PlyHeader("ascii", 1, 1) + "0 0 0 0 0 0\n2 0 0\n3 0 0 1 0\n"),
              AllOf(HasSubstr("bad.ply:19: "), HasSubstr("index 1")));
  EXPECT_THAT(complaint(PlyHeader("ascii", 1, 1) + "0 0 0 0 0 0\n2 0 0\n3 0 0\n"),
              HasSubstr("too early"));
  EXPECT_THAT(complaint(BinaryPly(false, std::nanf(""))),
              AllOf(HasSubstr("bad.ply, byte "), HasSubstr("vertex 3 is not finite")));
  EXPECT_THAT(complaint(BinaryPly(true, 0, 4)), HasSubstr("index 4 is out of range"));
  EXPECT_THAT(complaint(BinaryPly(false, 0, -1)), HasSubstr("index -1 is out of range"));
}

// Whatever is cut off, a line says so; nothing is asked for that the file can't hold.
TEST_F(MeshFile, PlyThatEndsEarlyOrLiesIsRefused) {
  const std::string whole = BinaryPly(false);
  for (std::size_t length = 0; length < whole.size(); length += 7) {
    EXPECT_NE(Complaint("cut.ply", whole.substr(0, length)), "was read") << length;
  }
  for (const char* count : {"4000000000", "99999999999999999"}) {
    for (const char* element : {"vertex 4", "edge 1", "face 2"}) {
      std::string lying = whole;
      const std::string name = std::string(element).substr(0, std::string(element).find(' '));
      lying.replace(lying.find(element), std::strlen(element), name + " " + count);
      EXPECT_THAT(Complaint("lying.ply", lying), HasSubstr("the header claims")) << element;
    }
  }
  const std::string strips =
      "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\n"
      "property float z\nelement face 1\nproperty list uint int vertex_indices\nend_header\n"
      "0 0 0\n4000000000 0 0 0\n";
  EXPECT_THAT(Complaint("list.ply", strips), HasSubstr("longer than the file"));
}

}  // namespace
}  // namespace lamella
