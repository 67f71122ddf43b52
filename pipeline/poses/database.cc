#include "pipeline/poses/database.h"

#include <cmath>
#include <cstring>

#include <fmt/format.h>
#include <sqlite3.h>

#include "lightfield/error.h"

namespace lamella {
namespace {

Error Failed(const std::filesystem::path& file, const std::string& reason) {
  return MachineError(file.string(), "COLMAP's database can't be used (" + reason + ")",
                      "check free space and permissions, then run the same command again");
}

// A prepared statement; steps through its rows.
class Statement {
 public:
  Statement(sqlite3* database, const std::filesystem::path& file, const char* sql)
      : database_(database), file_(file) {
    if (sqlite3_prepare_v2(database, sql, -1, &statement_, nullptr) != SQLITE_OK) Throw();
  }
  ~Statement() { sqlite3_finalize(statement_); }
  Statement(const Statement&) = delete;
  Statement& operator=(const Statement&) = delete;

  bool Step() {
    const int code = sqlite3_step(statement_);
    if (code != SQLITE_ROW && code != SQLITE_DONE) Throw();
    return code == SQLITE_ROW;
  }
  void Run() {
    Step();
    sqlite3_reset(statement_);
  }
  void Bind(int index, std::int64_t value) { sqlite3_bind_int64(statement_, index, value); }
  void Bind(int index, const std::string& text) {
    sqlite3_bind_text(statement_, index, text.c_str(), static_cast<int>(text.size()),
                      SQLITE_TRANSIENT);
  }
  void Bind(int index, const std::vector<double>& values) {
    sqlite3_bind_blob(statement_, index, values.data(),
                      static_cast<int>(values.size() * sizeof(double)), SQLITE_TRANSIENT);
  }
  std::int64_t Whole(int column) { return sqlite3_column_int64(statement_, column); }
  std::string Text(int column) {
    const void* text = sqlite3_column_text(statement_, column);
    return text ? std::string(static_cast<const char*>(text)) : std::string();
  }
  // A matrix of rows x columns; Failed where the blob is shorter than that.
  template <class T>
  std::vector<T> Matrix(int column, std::int64_t rows, std::int64_t columns) {
    std::vector<T> values(static_cast<std::size_t>(rows * columns));
    const auto bytes = static_cast<std::size_t>(sqlite3_column_bytes(statement_, column));
    if (bytes != values.size() * sizeof(T)) throw Failed(file_, "a matrix has the wrong size");
    if (bytes > 0) std::memcpy(values.data(), sqlite3_column_blob(statement_, column), bytes);
    return values;
  }

 private:
  [[noreturn]] void Throw() { throw Failed(file_, sqlite3_errmsg(database_)); }
  sqlite3* database_;
  std::filesystem::path file_;
  sqlite3_stmt* statement_ = nullptr;
};

}  // namespace

ColmapDatabase::ColmapDatabase(const std::filesystem::path& file) : file_(file) {
  if (sqlite3_open_v2(file.c_str(), &database_, SQLITE_OPEN_READWRITE, nullptr) != SQLITE_OK) {
    const std::string reason = sqlite3_errmsg(database_);
    sqlite3_close(database_);
    throw Failed(file, reason);
  }
}

ColmapDatabase::~ColmapDatabase() { sqlite3_close(database_); }

std::map<std::string, std::uint32_t> ColmapDatabase::ImageIds() {
  Statement select(database_, file_, "SELECT image_id, name FROM images");
  std::map<std::string, std::uint32_t> ids;
  while (select.Step()) ids[select.Text(1)] = static_cast<std::uint32_t>(select.Whole(0));
  return ids;
}

void ColmapDatabase::NumberImages(const std::vector<std::string>& names) {
  constexpr std::int64_t kAside = std::int64_t{1} << 30;  // beyond all numbers, old and new
  const std::map<std::string, std::uint32_t> old = ImageIds();
  Statement(database_, file_, "BEGIN").Run();
  for (const char* table : {"images", "keypoints", "descriptors"}) {
    const auto update = [&](const char* what) {
      return fmt::format("UPDATE {} SET image_id = {}", table, what);
    };
    Statement aside(database_, file_, update("image_id + ?").c_str());
    aside.Bind(1, kAside);
    aside.Run();
    Statement renumber(database_, file_, update("? WHERE image_id = ?").c_str());
    for (std::size_t i = 0; i < names.size(); ++i) {
      const auto id = old.find(names[i]);
      if (id == old.end()) continue;
      renumber.Bind(1, static_cast<std::int64_t>(i + 1));
      renumber.Bind(2, kAside + id->second);
      renumber.Run();
    }
  }
  Statement(database_, file_, "COMMIT").Run();
}

Descriptors ColmapDatabase::ReadDescriptors(std::uint32_t image_id) {
  Statement select(database_, file_, "SELECT rows, cols, data FROM descriptors WHERE image_id = ?");
  select.Bind(1, image_id);
  if (!select.Step() || select.Whole(0) == 0) return {};
  if (select.Whole(1) != Descriptors::kLength) throw Failed(file_, "descriptors are not SIFT's");
  Descriptors descriptors;
  descriptors.count = static_cast<int>(select.Whole(0));
  descriptors.rows = select.Matrix<std::uint8_t>(2, descriptors.count, Descriptors::kLength);
  return descriptors;
}

// A keypoint is x, y and either scale and orientation or the affine frame a11 a12 a21 a22.
std::vector<float> ColmapDatabase::ReadFeatureSizes(std::uint32_t image_id) {
  Statement select(database_, file_, "SELECT rows, cols, data FROM keypoints WHERE image_id = ?");
  select.Bind(1, image_id);
  if (!select.Step()) return {};
  const std::int64_t rows = select.Whole(0), columns = select.Whole(1);
  const std::vector<float> data = select.Matrix<float>(2, rows, columns);
  std::vector<float> sizes(static_cast<std::size_t>(rows), 0.0F);
  for (std::size_t i = 0; i < sizes.size() && columns >= 4; ++i) {
    const float* shape = data.data() + i * static_cast<std::size_t>(columns) + 2;
    sizes[i] =
        columns == 6 ? std::abs(shape[0] * shape[3] - shape[1] * shape[2]) : shape[0] * shape[0];
  }
  return sizes;
}

void ColmapDatabase::TakeMatches(const std::filesystem::path& other) {
  Statement attach(database_, file_, "ATTACH DATABASE ? AS other");
  attach.Bind(1, other.string());
  attach.Run();
  for (const char* table : {"matches", "two_view_geometries"}) {
    Statement(database_, file_,
              fmt::format("INSERT INTO main.{0} SELECT * FROM other.{0}", table).c_str())
        .Run();
  }
  Statement(database_, file_, "DETACH DATABASE other").Run();
}

int ColmapDatabase::CountVerifiedPairs() {
  Statement select(database_, file_, "SELECT COUNT(*) FROM two_view_geometries WHERE rows > 0");
  select.Step();
  return static_cast<int>(select.Whole(0));
}

std::int64_t ColmapDatabase::CountVerifiedMatches() {
  Statement select(database_, file_, "SELECT IFNULL(SUM(rows), 0) FROM two_view_geometries");
  select.Step();
  return select.Whole(0);
}

void ColmapDatabase::ReplaceCameras(const std::vector<CameraRow>& cameras) {
  Statement(database_, file_, "BEGIN").Run();
  Statement(database_, file_, "DELETE FROM cameras").Run();
  Statement insert(database_, file_, "INSERT INTO cameras VALUES (?, ?, ?, ?, ?, ?)");
  Statement update(database_, file_, "UPDATE images SET camera_id = ? WHERE image_id = ?");
  for (std::size_t i = 0; i < cameras.size(); ++i) {
    const auto id = static_cast<std::int64_t>(i + 1);
    insert.Bind(1, id);
    insert.Bind(2, cameras[i].camera.model_id);
    insert.Bind(3, cameras[i].width);
    insert.Bind(4, cameras[i].height);
    insert.Bind(5, cameras[i].camera.parameters);
    insert.Bind(6, cameras[i].prior ? 1 : 0);
    insert.Run();
    for (const std::uint32_t image_id : cameras[i].image_ids) {
      update.Bind(1, id);
      update.Bind(2, image_id);
      update.Run();
    }
  }
  Statement(database_, file_, "COMMIT").Run();
}

}  // namespace lamella
