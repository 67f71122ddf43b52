#include "datasets_synthetic/mesh_ply.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cctype>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>
#include <optional>
#include <vector>

#include <fmt/format.h>

#include "lightfield/error.h"

namespace lamella {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

enum class Format { kAscii, kLittleEndian, kBigEndian };
enum class Type { kInt8, kUint8, kInt16, kUint16, kInt32, kUint32, kFloat, kDouble };

std::size_t BytesOf(Type type) {
  constexpr std::array<std::size_t, 8> kBytes = {1, 1, 2, 2, 4, 4, 4, 8};
  return kBytes[static_cast<std::size_t>(type)];
}
bool IsInteger(Type type) { return type < Type::kFloat; }

struct Property {
  std::string name;
  Type type = Type::kFloat;
  std::optional<Type> count_type;  // of a list
};

struct Element {
  std::string name;
  std::uint64_t count = 0;
  std::vector<Property> properties;

  int Find(std::initializer_list<std::string_view> names) const {  // -1: none of them
    for (const std::string_view wanted : names) {
      for (std::size_t i = 0; i < properties.size(); ++i) {
        if (properties[i].name == wanted) return static_cast<int>(i);
      }
    }
    return -1;
  }
};

// The file, and how far it has been read.
class Source {
 public:
  Source(std::string_view text, const std::string& name) : text_(text), name_(name) {}

  [[noreturn]] void Fail(const std::string& what) const {
    const std::string where = format == Format::kAscii ? fmt::format("{}:{}", name_, line_)
                                                       : fmt::format("{}, byte {}", name_, at_);
    throw InputError(where, what, "repair the file");
  }

  std::size_t Left() const { return text_.size() - at_; }

  std::string_view HeaderLine() {
    if (Left() == 0) Fail("the header has no end_header");
    ++line_;
    const std::size_t end = std::min(text_.find('\n', at_), text_.size());
    std::string_view line = text_.substr(at_, end - at_);
    at_ = std::min(end + 1, text_.size());
    while (!line.empty() && std::isspace(static_cast<unsigned char>(line.back())) != 0) {
      line.remove_suffix(1);
    }
    return line;
  }
  void BeginBody() { ++line_; }  // lines count from 1 there, too

  double Value(Type type) { return format == Format::kAscii ? Word(type) : Binary(type); }

  Format format = Format::kAscii;

 private:
  double Word(Type type) {
    while (at_ < text_.size() && std::isspace(static_cast<unsigned char>(text_[at_])) != 0) {
      line_ += text_[at_++] == '\n' ? 1 : 0;
    }
    std::size_t end = at_;
    while (end < text_.size() && std::isspace(static_cast<unsigned char>(text_[end])) == 0) ++end;
    const std::string_view word = text_.substr(at_, end - at_);
    if (word.empty()) Fail("the file ends too early");
    const char* const first = word.data() + (word[0] == '+' ? 1 : 0);
    const char* const last = word.data() + word.size();
    double value = 0;
    const auto [stop, error] = std::from_chars(first, last, value);
    if (error == std::errc::result_out_of_range) Fail(fmt::format("{} is out of range", word));
    if (error != std::errc() || stop != last) Fail(fmt::format("\"{}\" is no number", word));
    if (IsInteger(type) && value != std::floor(value)) {
      Fail(fmt::format("{} is no whole number", word));
    }
    at_ = end;
    return value;
  }

  template <class T>
  double Read() {
    std::array<unsigned char, sizeof(T)> bytes;
    std::memcpy(bytes.data(), text_.data() + at_, sizeof(T));
    if ((format == Format::kBigEndian) != (std::endian::native == std::endian::big)) {
      std::reverse(bytes.begin(), bytes.end());
    }
    at_ += sizeof(T);
    return static_cast<double>(std::bit_cast<T>(bytes));
  }

  double Binary(Type type) {
    if (Left() < BytesOf(type)) Fail("the file ends too early");
    switch (type) {
      case Type::kInt8:
        return Read<std::int8_t>();
      case Type::kUint8:
        return Read<std::uint8_t>();
      case Type::kInt16:
        return Read<std::int16_t>();
      case Type::kUint16:
        return Read<std::uint16_t>();
      case Type::kInt32:
        return Read<std::int32_t>();
      case Type::kUint32:
        return Read<std::uint32_t>();
      case Type::kFloat:
        return Read<float>();
      case Type::kDouble:
        return Read<double>();
    }
    return 0;
  }

  std::string_view text_;
  std::string name_;
  std::size_t at_ = 0;
  int line_ = 0;
};

std::vector<std::string_view> WordsOf(std::string_view line) {
  std::vector<std::string_view> words;
  for (std::size_t at = line.find_first_not_of(" \t"); at < line.size();
       at = line.find_first_not_of(" \t", at)) {
    const std::size_t end = std::min(line.find_first_of(" \t", at), line.size());
    words.push_back(line.substr(at, end - at));
    at = end;
  }
  return words;
}

Type TypeOf(std::string_view word, const Source& source) {
  constexpr std::array<std::array<std::string_view, 2>, 8> kNames = {{{"char", "int8"},
                                                                      {"uchar", "uint8"},
                                                                      {"short", "int16"},
                                                                      {"ushort", "uint16"},
                                                                      {"int", "int32"},
                                                                      {"uint", "uint32"},
                                                                      {"float", "float32"},
                                                                      {"double", "float64"}}};
  for (std::size_t i = 0; i < kNames.size(); ++i) {
    if (word == kNames[i][0] || word == kNames[i][1]) return static_cast<Type>(i);
  }
  source.Fail(fmt::format("there is no type \"{}\"", word));
}

Property PropertyOf(const std::vector<std::string_view>& words, const Source& source) {
  Property property;
  if (words.size() == 5 && words[1] == "list") {
    property.count_type = TypeOf(words[2], source);
    if (!IsInteger(*property.count_type)) source.Fail("a list's length must be of an integer type");
    property.type = TypeOf(words[3], source);
  } else if (words.size() == 3) {
    property.type = TypeOf(words[1], source);
  } else {
    source.Fail("a property is \"property TYPE NAME\" or \"property list TYPE TYPE NAME\"");
  }
  property.name = words.back();
  return property;
}

Element ElementOf(const std::vector<std::string_view>& words, const Source& source) {
  if (words.size() != 3) source.Fail("an element is \"element NAME COUNT\"");
  Element element;
  element.name = words[1];
  const char* const last = words[2].data() + words[2].size();
  const auto [end, error] = std::from_chars(words[2].data(), last, element.count);
  if (error != std::errc() || end != last) {
    source.Fail(fmt::format("\"{}\" is no count", words[2]));
  }
  return element;
}

std::vector<Element> ReadHeader(Source& source) {
  if (source.Left() == 0 || source.HeaderLine() != "ply") source.Fail("no PLY file");
  std::vector<Element> elements;
  std::optional<Format> format;
  for (;;) {
    const std::vector<std::string_view> words = WordsOf(source.HeaderLine());
    if (words.empty() || words[0] == "comment" || words[0] == "obj_info") continue;
    if (words[0] == "end_header") break;
    if (words[0] == "format" && words.size() >= 2) {
      if (words[1] == "ascii") format = Format::kAscii;
      if (words[1] == "binary_little_endian") format = Format::kLittleEndian;
      if (words[1] == "binary_big_endian") format = Format::kBigEndian;
      if (!format) source.Fail(fmt::format("there is no format \"{}\"", words[1]));
    } else if (words[0] == "element") {
      elements.push_back(ElementOf(words, source));
    } else if (words[0] == "property" && !elements.empty()) {
      elements.back().properties.push_back(PropertyOf(words, source));
    } else {
      source.Fail(fmt::format("\"{}\" is not understood", words[0]));
    }
  }
  if (!format) source.Fail("the header names no format");
  source.BeginBody();
  source.format = *format;
  return elements;
}

// Whether the rest of the file can hold what the header claims, before memory is asked for.
void CheckCount(const Element& element, const Source& source) {
  std::uint64_t least = 0;  // bytes of one
  for (const Property& property : element.properties) {
    const Type type = property.count_type.value_or(property.type);
    least += source.format == Format::kAscii ? 2 : BytesOf(type);  // a digit and a blank
  }
  if (least == 0) return;
  const std::uint64_t fitting = (source.Left() + 1) / least;  // no line's end after the last
  if (element.count > fitting || element.count > std::numeric_limits<int>::max()) {
    source.Fail(fmt::format("the header claims {} of \"{}\", the file can hold {} at most",
                            element.count, element.name, fitting));
  }
}

// One item: its plain properties' values; the list that was asked for goes to `list`.
void ReadItem(const Element& element, int list_property, Source& source,
              std::vector<double>* values, std::vector<double>* list) {
  for (std::size_t i = 0; i < element.properties.size(); ++i) {
    const Property& property = element.properties[i];
    if (!property.count_type) {
      (*values)[i] = source.Value(property.type);
      continue;
    }
    const double length = source.Value(*property.count_type);
    if (!(length >= 0)) source.Fail("a list of negative length");
    if (length > static_cast<double>(source.Left())) {
      source.Fail(fmt::format("a list of {} is longer than the file", length));
    }
    const bool wanted = static_cast<int>(i) == list_property;
    if (wanted) list->clear();
    for (double k = 0; k < length; ++k) {
      const double value = source.Value(property.type);
      if (wanted) list->push_back(value);
    }
  }
}

void ReadVertices(const Element& element, Source& source, Mesh* mesh) {
  const std::array<int, 3> place = {element.Find({"x"}), element.Find({"y"}), element.Find({"z"})};
  const std::array<int, 3> normal = {element.Find({"nx"}), element.Find({"ny"}),
                                     element.Find({"nz"})};
  const std::array<int, 2> uv = {element.Find({"u", "s", "texture_u"}),
                                 element.Find({"v", "t", "texture_v"})};
  const auto all = [](const auto& found) {
    return std::all_of(found.begin(), found.end(), [](int i) { return i >= 0; });
  };
  if (!all(place)) source.Fail("vertices need x, y and z");
  for (const Property& property : element.properties) {
    if (property.count_type) source.Fail("vertices with lists are not understood");
  }
  const auto count = static_cast<std::size_t>(element.count);
  mesh->vertices.reserve(count);
  if (all(normal)) mesh->normals.reserve(count);
  if (all(uv)) mesh->texture_coordinates.reserve(count);
  std::vector<double> values(element.properties.size()), unused;
  for (std::size_t i = 0; i < count; ++i) {
    ReadItem(element, -1, source, &values, &unused);
    const auto at = [&](int property) { return values[static_cast<std::size_t>(property)]; };
    const Vector3d vertex(at(place[0]), at(place[1]), at(place[2]));
    if (!vertex.allFinite()) source.Fail(fmt::format("vertex {} is not finite", i));
    mesh->vertices.push_back(vertex);
    if (all(normal)) {
      const Vector3d n(at(normal[0]), at(normal[1]), at(normal[2]));
      if (!n.allFinite()) source.Fail(fmt::format("the normal of vertex {} is not finite", i));
      mesh->normals.emplace_back(n.stableNormalized());
    }
    if (all(uv)) {
      const Vector2d t(at(uv[0]), at(uv[1]));
      if (!t.allFinite()) {
        source.Fail(fmt::format("the texture coordinates of vertex {} are not finite", i));
      }
      mesh->texture_coordinates.push_back(t);
    }
  }
}

void ReadFaces(const Element& element, std::uint64_t num_vertices, Source& source, Mesh* mesh) {
  const int list = element.Find({"vertex_indices", "vertex_index"});
  if (list < 0 && element.count == 0) return;
  if (list < 0 || !element.properties[static_cast<std::size_t>(list)].count_type ||
      !IsInteger(element.properties[static_cast<std::size_t>(list)].type)) {
    source.Fail("faces need a list of integers named vertex_indices");
  }
  mesh->triangles.reserve(static_cast<std::size_t>(element.count));
  std::vector<double> values(element.properties.size()), indices;
  for (std::uint64_t i = 0; i < element.count; ++i) {
    ReadItem(element, list, source, &values, &indices);
    if (indices.size() < 3) source.Fail(fmt::format("face {} has {} corners", i, indices.size()));
    for (const double index : indices) {
      if (!(index >= 0 && index < static_cast<double>(num_vertices))) {
        source.Fail(fmt::format("face {}: index {} is out of range: there are {} vertices", i,
                                index, num_vertices));
      }
    }
    for (std::size_t k = 2; k < indices.size(); ++k) {
      mesh->triangles.emplace_back(static_cast<int>(indices[0]), static_cast<int>(indices[k - 1]),
                                   static_cast<int>(indices[k]));
    }
  }
}

}  // namespace

Mesh ParsePly(std::string_view text, const std::string& name) {
  Source source(text, name);
  const std::vector<Element> elements = ReadHeader(source);
  std::uint64_t num_vertices = 0;
  bool has_vertices = false;
  for (const Element& element : elements) {
    if (element.name == "tristrips") source.Fail("triangle strips are not read: write faces");
    if (element.name != "vertex") continue;
    if (has_vertices) source.Fail("two elements \"vertex\"");
    has_vertices = true;
    num_vertices = element.count;
  }
  if (!has_vertices) source.Fail("there is no element \"vertex\"");
  Mesh mesh;
  for (const Element& element : elements) {
    CheckCount(element, source);
    if (element.name == "vertex") {
      ReadVertices(element, source, &mesh);
    } else if (element.name == "face") {
      ReadFaces(element, num_vertices, source, &mesh);
    } else if (!element.properties.empty()) {
      std::vector<double> values(element.properties.size()), unused;
      for (std::uint64_t i = 0; i < element.count; ++i) {
        ReadItem(element, -1, source, &values, &unused);
      }
    }
  }
  return mesh;
}

}  // namespace lamella
