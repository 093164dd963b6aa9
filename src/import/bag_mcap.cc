#include <archive.h>
#include <archive_entry.h>
#include <fmt/format.h>

#include <fstream>
#include <map>
#include <memory>

#include "armtrue/text/input_error.h"
#include "import/bag.h"

namespace armtrue {
namespace {

using namespace std::string_view_literals;

constexpr std::string_view kMagic = "\x89MCAP0\r\n"sv;
constexpr std::uint64_t kLargestChunk = 1 << 30;  // usual are some MB
// Records of these kinds are read; others are indices, attachments and metadata.
enum Kind : unsigned char { schema = 3, channel = 4, message = 5, chunk = 6, data_end = 15 };

// The fields of a record, little-endian. Throws InputError if the record ends too early.
class Fields {
 public:
  Fields(std::string_view bytes, const std::string& file) : rest_(bytes), file_(file) {}

  std::uint64_t number(size_t size) {
    const std::string_view bytes = take(size);
    std::uint64_t value = 0;
    for (size_t k = size; k-- > 0;) {
      const unsigned char byte = bytes[k];
      value = value << 8 | byte;
    }
    return value;
  }
  std::string_view text() { return take(number(4)); }
  std::string_view take(std::uint64_t size) {
    if (size > rest_.size())
      throw InputError(file_ +
                       ": is damaged: a record is longer than what holds it; try `mcap recover`");
    const std::string_view taken = rest_.substr(0, size);
    rest_.remove_prefix(size);
    return taken;
  }
  std::string_view rest() const { return rest_; }

 private:
  std::string_view rest_;
  const std::string& file_;
};

std::string unpacked(std::string_view packed, std::string_view how, std::uint64_t size,
                     const std::string& file) {
  if (how.empty()) return std::string(packed);
  const auto damaged = [&] {
    return InputError(fmt::format(
        "{}: is damaged: a chunk, packed by '{}', does not unpack; try `mcap recover`", file, how));
  };
  if (how != "zstd" && how != "lz4")
    throw InputError(
        fmt::format("{}: chunks are packed by '{}', not by zstd or lz4; pack them again "
                    "with `mcap compress`",
                    file, how));
  std::string bytes(size, '\0');
  if (size == 0) return bytes;
  const std::unique_ptr<archive, decltype(&archive_read_free)> reader(archive_read_new(),
                                                                      archive_read_free);
  archive_read_support_format_raw(reader.get());
  how == "zstd" ? archive_read_support_filter_zstd(reader.get())
                : archive_read_support_filter_lz4(reader.get());
  archive_entry* entry = nullptr;
  if (archive_read_open_memory(reader.get(), packed.data(), packed.size()) != ARCHIVE_OK ||
      archive_read_next_header(reader.get(), &entry) != ARCHIVE_OK ||
      archive_filter_code(reader.get(), 0) == ARCHIVE_FILTER_NONE)
    throw damaged();
  size_t done = 0;
  while (done < bytes.size()) {
    const auto read = archive_read_data(reader.get(), bytes.data() + done, bytes.size() - done);
    if (read <= 0) throw damaged();
    done += read;
  }
  return bytes;
}

class Mcap {
 public:
  Mcap(const std::string& file, const BagVisitor& visitor) : file_(file), visitor_(visitor) {}

  void visit() {
    std::ifstream stream(file_, std::ios::binary | std::ios::ate);
    if (!stream) throw InputError(file_ + ": cannot be read; check the path and its rights");
    std::uint64_t left = stream.tellg();
    stream.seekg(0);
    if (left < kMagic.size() || take(stream, kMagic.size(), left) != kMagic)
      throw InputError(file_ +
                       ": is no recording in MCAP, whose first bytes it lacks; give a file "
                       "that `ros2 bag record` wrote");
    while (true) {
      if (left < 9) throw cut();
      const std::string head = take(stream, 9, left);
      const unsigned char kind = head[0];
      const std::uint64_t size = Fields(std::string_view(head).substr(1), file_).number(8);
      if (kind == Kind::data_end) return;
      if (size > left) throw cut();
      if (kind < Kind::schema || kind > Kind::chunk) {
        stream.seekg(size, std::ios::cur);
        left -= size;
        continue;
      }
      if (size > kLargestChunk) throw too_large();
      record(kind, take(stream, size, left));
    }
  }

 private:
  InputError cut() const {
    return InputError(file_ +
                      ": ends within a record, as if the recorder was stopped; try `mcap recover`");
  }
  InputError too_large() const {
    return InputError(
        fmt::format("{}: a record is larger than {} MB; pack it again in smaller chunks", file_,
                    kLargestChunk >> 20));
  }

  std::string take(std::ifstream& stream, std::uint64_t size, std::uint64_t& left) const {
    std::string bytes(size, '\0');
    if (!stream.read(bytes.data(), size)) throw cut();
    left -= size;
    return bytes;
  }

  void record(unsigned char kind, std::string_view bytes) {
    Fields fields(bytes, file_);
    if (kind == Kind::schema) {
      const std::uint64_t id = fields.number(2);
      types_[id] = fields.text();
    } else if (kind == Kind::channel) {
      const std::uint64_t id = fields.number(2), of_schema = fields.number(2);
      const std::string name(fields.text()), encoding(fields.text());
      enter({name, types_.contains(of_schema) ? types_[of_schema] : ""}, id, encoding);
    } else if (kind == Kind::message) {
      const auto wanted = wanted_.find(fields.number(2));
      fields.number(4);  // of the sequence
      const std::int64_t logged = fields.number(8);
      fields.number(8);  // when it was published
      if (wanted != wanted_.end()) visitor_.take(wanted->second, logged, fields.rest());
    } else {
      open_chunk(fields);
    }
  }

  void enter(const BagTopic& topic, std::uint64_t id, const std::string& encoding) {
    if (!visitor_.wants(topic)) return;
    if (encoding != "cdr")
      throw InputError(
          fmt::format("{}: topic '{}' is serialized as '{}', not as cdr, which ROS 2 writes; {}",
                      file_, topic.name, encoding,
                      encoding == "ros1" ? "of ROS 1 export the topics as text: `rostopic echo -p`"
                                         : "convert it with `ros2 bag convert`"));
    wanted_[id] = topic;
  }

  void open_chunk(Fields fields) {
    fields.take(16);  // first and last time
    const std::uint64_t size = fields.number(8);
    fields.number(4);  // checksum
    if (size > kLargestChunk) throw too_large();
    const std::string_view how = fields.text();
    const std::string records = unpacked(fields.take(fields.number(8)), how, size, file_);
    for (Fields inside(records, file_); !inside.rest().empty();) {
      const auto kind = static_cast<unsigned char>(inside.number(1));
      const std::string_view bytes = inside.take(inside.number(8));
      if (kind >= Kind::schema && kind <= Kind::message) record(kind, bytes);
    }
  }

  const std::string& file_;
  const BagVisitor& visitor_;
  std::map<std::uint64_t, std::string> types_;  // by schema
  std::map<std::uint64_t, BagTopic> wanted_;    // by channel
};

}  // namespace

void visit_mcap(const std::string& file, const BagVisitor& visitor) { Mcap(file, visitor).visit(); }

}  // namespace armtrue
