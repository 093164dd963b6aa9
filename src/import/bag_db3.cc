#include <fmt/format.h>
#include <sqlite3.h>

#include <filesystem>
#include <memory>
#include <utility>
#include <vector>

#include "armtrue/text/input_error.h"
#include "import/bag.h"

namespace armtrue {
namespace {

using Database = std::unique_ptr<sqlite3, decltype(&sqlite3_close)>;
using Statement = std::unique_ptr<sqlite3_stmt, decltype(&sqlite3_finalize)>;

// SQLite may write files beside a database that it only reads, except with immutable=1. A database
// with a write-ahead log that was not merged needs these files.
std::string address_of(const std::string& file) {
  std::string address = "file:";
  for (const char c : file)
    address += c == '%' || c == '?' || c == '#' ? fmt::format("%{:02X}", c) : std::string(1, c);
  std::error_code none;
  const auto log = std::filesystem::file_size(file + "-wal", none);
  return address + (none || log == 0 ? "?immutable=1" : "");
}

class Db3 {
 public:
  explicit Db3(const std::string& file) : file_(file), database_(nullptr, sqlite3_close) {
    sqlite3* database = nullptr;
    const int code = sqlite3_open_v2(address_of(file).c_str(), &database,
                                     SQLITE_OPEN_READONLY | SQLITE_OPEN_URI, nullptr);
    database_.reset(database);
    if (code != SQLITE_OK) fail();
  }

  Statement prepare(const char* query) {
    sqlite3_stmt* statement = nullptr;
    if (sqlite3_prepare_v2(database_.get(), query, -1, &statement, nullptr) != SQLITE_OK) fail();
    return {statement, sqlite3_finalize};
  }

  // The next row; false behind the last one.
  bool next(const Statement& statement) {
    const int code = sqlite3_step(statement.get());
    if (code != SQLITE_ROW && code != SQLITE_DONE) fail();
    return code == SQLITE_ROW;
  }

 private:
  [[noreturn]] void fail() const {
    throw InputError(
        fmt::format("{}: is no recording of ROS 2, or cannot be read or is damaged ({}); "
                    "try `ros2 bag info`, and record it again if that fails too",
                    file_, sqlite3_errmsg(database_.get())));
  }

  std::string file_;
  Database database_;
};

std::string text_of(const Statement& statement, int column) {
  const auto* const text = sqlite3_column_text(statement.get(), column);
  return text ? std::string(reinterpret_cast<const char*>(text),
                            sqlite3_column_bytes(statement.get(), column))
              : std::string();
}

}  // namespace

void visit_db3(const std::string& file, const BagVisitor& visitor) {
  Db3 recording(file);
  std::vector<std::pair<sqlite3_int64, BagTopic>> wanted;
  const Statement topics =
      recording.prepare("SELECT id, name, type, serialization_format FROM topics ORDER BY id");
  while (recording.next(topics)) {
    const BagTopic topic{text_of(topics, 1), text_of(topics, 2)};
    if (!visitor.wants(topic)) continue;
    if (text_of(topics, 3) != "cdr")
      throw InputError(
          fmt::format("{}: topic '{}' is serialized as '{}', not as cdr; convert it with "
                      "`ros2 bag convert`",
                      file, topic.name, text_of(topics, 3)));
    wanted.emplace_back(sqlite3_column_int64(topics.get(), 0), topic);
  }
  const Statement messages = recording.prepare(
      "SELECT timestamp, data FROM messages WHERE topic_id = ? ORDER BY timestamp, id");
  for (const auto& [id, topic] : wanted) {
    sqlite3_reset(messages.get());
    sqlite3_bind_int64(messages.get(), 1, id);
    while (recording.next(messages)) {
      const auto* const data = static_cast<const char*>(sqlite3_column_blob(messages.get(), 1));
      const size_t size = sqlite3_column_bytes(messages.get(), 1);
      visitor.take(topic, sqlite3_column_int64(messages.get(), 0),
                   {data ? data : "", data ? size : 0});
    }
  }
}

}  // namespace armtrue
