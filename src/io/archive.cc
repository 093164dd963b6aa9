#include "armtrue/io/archive.h"

#include <archive.h>
#include <archive_entry.h>
#include <fmt/format.h>
#include <locale.h>

#include <algorithm>
#include <array>
#include <memory>
#include <set>

#include "armtrue/text/edit_distance.h"
#include "armtrue/text/input_error.h"
#include "io/file_bytes.h"

namespace armtrue {
namespace {

using ReadHandle = std::unique_ptr<archive, decltype(&archive_read_free)>;
using WriteHandle = std::unique_ptr<archive, decltype(&archive_write_free)>;
using EntryHandle = std::unique_ptr<archive_entry, decltype(&archive_entry_free)>;

// A backup of a controller has some tens of MB; all of it is held in memory, twice when it is
// written.
constexpr size_t kMostBytes = 256'000'000;
constexpr size_t kMostMembers = 100'000;
constexpr size_t kBlock = 1 << 16;
constexpr const char* kUnpack =
    "unpack it into a new folder, and give that folder as --project (unzip FILE -d FOLDER, tar -xf "
    "FILE -C FOLDER)";

// libarchive converts names by the locale of the thread; armtrue's are UTF-8.
class Utf8Names {
 public:
  Utf8Names() : utf8_(newlocale(LC_CTYPE_MASK, "C.UTF-8", nullptr)) {
    if (utf8_) before_ = uselocale(utf8_);
  }
  ~Utf8Names() {
    if (!utf8_) return;
    uselocale(before_);
    freelocale(utf8_);
  }
  Utf8Names(const Utf8Names&) = delete;
  Utf8Names& operator=(const Utf8Names&) = delete;

 private:
  locale_t utf8_, before_ = nullptr;
};

std::string text_of(const char* text) { return text ? text : ""; }

// A name inside the archive: parts without "." between '/'. Archives of Windows have '\' there.
std::string path_inside(const std::string& stated, const std::string& file) {
  std::string path;
  size_t begin = 0;
  const auto refuse = [&] {
    throw InputError(fmt::format("{}: the name '{}' leads out of the archive; {}", file, stated,
                                 "make the archive anew, from the folder of the backup"));
  };
  if (stated.starts_with('/') || stated.starts_with('\\') ||
      (stated.size() > 1 && stated[1] == ':'))
    refuse();
  while (begin <= stated.size()) {
    const size_t end = std::min(stated.find_first_of("/\\", begin), stated.size());
    const std::string part = stated.substr(begin, end - begin);
    if (part == "..") refuse();
    if (!part.empty() && part != ".") path += (path.empty() ? "" : "/") + part;
    begin = end + 1;
  }
  return path;
}

ReadHandle opened(const std::string& bytes, const std::string& file) {
  ReadHandle reader(archive_read_new(), archive_read_free);
  archive_read_support_format_zip(reader.get());
  archive_read_support_format_tar(reader.get());
  archive_read_support_filter_gzip(reader.get());
  archive_read_support_filter_bzip2(reader.get());
  archive_read_support_filter_xz(reader.get());
  if (archive_read_open_memory(reader.get(), bytes.data(), bytes.size()) != ARCHIVE_OK)
    throw InputError(fmt::format("{}: is no zip or tar file ({}); {}", file,
                                 text_of(archive_error_string(reader.get())), kUnpack));
  return reader;
}

ArchiveMember member_of(archive_entry* entry, const std::string& file) {
  ArchiveMember member;
  const char* name = archive_entry_pathname(entry);
  if (!name) name = archive_entry_pathname_utf8(entry);
  member.stated_path = text_of(name);
  member.path = path_inside(member.stated_path, file);
  const auto type = archive_entry_filetype(entry);
  const bool links = archive_entry_hardlink(entry) != nullptr;
  if (links || (type != AE_IFREG && type != AE_IFDIR))
    throw InputError(fmt::format(
        "{}: '{}' is {}, which no backup of a controller has; {}", file, member.stated_path,
        links || type == AE_IFLNK ? "a link" : "no file and no folder", kUnpack));
  if (archive_entry_is_encrypted(entry))
    throw InputError(fmt::format("{}: '{}' is encrypted; {} with its password", file,
                                 member.stated_path, kUnpack));
  member.is_folder = type == AE_IFDIR;
  member.mode = archive_entry_perm(entry);
  member.modified_s = archive_entry_mtime(entry);
  member.modified_ns = archive_entry_mtime_nsec(entry);
  member.user = archive_entry_uid(entry);
  member.group = archive_entry_gid(entry);
  member.user_name = text_of(archive_entry_uname(entry));
  member.group_name = text_of(archive_entry_gname(entry));
  return member;
}

void read_content(archive* reader, ArchiveMember& member, size_t& total, const std::string& file) {
  std::array<char, kBlock> block;
  for (;;) {
    const auto size = archive_read_data(reader, block.data(), block.size());
    if (size == 0) return;
    if (size < 0)
      throw InputError(fmt::format("{}: '{}' is damaged ({}); make the archive anew, or {}", file,
                                   member.stated_path, text_of(archive_error_string(reader)),
                                   kUnpack));
    total += size;
    if (total > kMostBytes)
      throw InputError(fmt::format("{}: holds more than {} MB, unpacked, at '{}'; {}", file,
                                   kMostBytes / 1'000'000, member.stated_path, kUnpack));
    member.content.append(block.data(), size);
  }
}

struct KnownEnding {
  const char *ending, *kind;
};
constexpr std::array<KnownEnding, 8> kEndings{{{".zip", ".zip"},
                                               {".tar", ".tar"},
                                               {".tgz", ".tar.gz"},
                                               {".tar.gz", ".tar.gz"},
                                               {".tbz2", ".tar.bz2"},
                                               {".tar.bz2", ".tar.bz2"},
                                               {".txz", ".tar.xz"},
                                               {".tar.xz", ".tar.xz"}}};

}  // namespace

bool is_archive_name(const std::string& path, std::string& ending) {
  const std::string lower = lower_case(path);
  for (const KnownEnding& known : kEndings)
    if (lower.ends_with(known.ending)) {
      ending = known.kind;
      return true;
    }
  return false;
}

Archive::Archive(const std::string& path) : file_(path) {
  const Utf8Names utf8;
  const std::string bytes = bytes_of_file(path);
  sha256_ = sha256_of(bytes);
  const ReadHandle reader = opened(bytes, path);
  std::set<std::string> names;
  size_t total = 0;
  archive_entry* entry = nullptr;
  for (;;) {
    const int code = archive_read_next_header(reader.get(), &entry);
    if (code == ARCHIVE_EOF) break;
    if (code != ARCHIVE_OK && code != ARCHIVE_WARN)
      throw InputError(fmt::format("{}: is no zip or tar file, or is damaged ({}); {}", path,
                                   text_of(archive_error_string(reader.get())), kUnpack));
    ArchiveMember member = member_of(entry, path);
    if (member.is_folder && member.path.empty()) continue;  // "./"
    if (!names.insert(member.path).second)
      throw InputError(fmt::format("{}: has two members '{}'; {}", path, member.path, kUnpack));
    if (names.size() > kMostMembers)
      throw InputError(
          fmt::format("{}: has more than {} members; {}", path, kMostMembers, kUnpack));
    if (!member.is_folder) read_content(reader.get(), member, total, path);
    members_.push_back(std::move(member));
  }
  if (members_.empty()) throw InputError(path + ": is an archive without a file; check it");
  format_ = archive_format(reader.get());
  filter_ = archive_filter_code(reader.get(), 0);
}

std::string Archive::with(const std::map<std::string, std::string>& changed) const {
  const Utf8Names utf8;
  WriteHandle writer(archive_write_new(), archive_write_free);
  const bool is_zip = (format_ & ARCHIVE_FORMAT_BASE_MASK) == ARCHIVE_FORMAT_ZIP;
  if (is_zip) {
    archive_write_set_format_zip(writer.get());
  } else {
    const auto has_fraction = [](const ArchiveMember& member) { return member.modified_ns != 0; };
    if (std::ranges::any_of(members_, has_fraction))
      archive_write_set_format_pax(writer.get());
    else
      archive_write_set_format_pax_restricted(writer.get());
    archive_write_add_filter(writer.get(), filter_);
    // Without a time stamp, so that the same input gives the same bytes.
    archive_write_set_filter_option(writer.get(), "gzip", "timestamp", nullptr);
  }
  archive_write_set_bytes_in_last_block(writer.get(), 1);
  std::string bytes;
  const auto fail = [&](const std::string& at) {
    throw InputError(
        fmt::format("{}: '{}' cannot be written into an archive ({}); give a folder as "
                    "--project-out",
                    file_, at, text_of(archive_error_string(writer.get()))));
  };
  const auto append = [](archive*, void* to, const void* from, size_t size) -> la_ssize_t {
    static_cast<std::string*>(to)->append(static_cast<const char*>(from), size);
    return size;
  };
  if (archive_write_open(writer.get(), &bytes, nullptr, append, nullptr) != ARCHIVE_OK) fail(file_);
  for (const ArchiveMember& member : members_) {
    const auto found = changed.find(member.path);
    const std::string& content = found == changed.end() ? member.content : found->second;
    EntryHandle entry(archive_entry_new(), archive_entry_free);
    archive_entry_set_pathname(entry.get(), member.stated_path.c_str());
    archive_entry_set_filetype(entry.get(), member.is_folder ? AE_IFDIR : AE_IFREG);
    archive_entry_set_perm(entry.get(), member.mode);
    archive_entry_set_mtime(entry.get(), member.modified_s, member.modified_ns);
    archive_entry_set_uid(entry.get(), member.user);
    archive_entry_set_gid(entry.get(), member.group);
    archive_entry_set_uname(entry.get(), member.user_name.c_str());
    archive_entry_set_gname(entry.get(), member.group_name.c_str());
    archive_entry_set_size(entry.get(), content.size());
    if (archive_write_header(writer.get(), entry.get()) != ARCHIVE_OK) fail(member.stated_path);
    if (!content.empty() &&
        archive_write_data(writer.get(), content.data(), content.size()) != std::ssize(content))
      fail(member.stated_path);
  }
  if (archive_write_close(writer.get()) != ARCHIVE_OK) fail(file_);
  return bytes;
}

}  // namespace armtrue
