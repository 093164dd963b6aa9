#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

namespace armtrue {

/// A file or folder in an archive.
struct ArchiveMember {
  std::string path;  ///< with '/' between folders, without a leading "./"
  std::string content;
  bool is_folder = false;
  std::string stated_path;  ///< as the archive has it
  unsigned mode = 0;        ///< permissions
  std::int64_t modified_s = 0;
  long modified_ns = 0;
  std::int64_t user = 0, group = 0;
  std::string user_name, group_name;
};

/// Whether a file name is that of an archive: .zip, .tar, .tgz, .tar.gz, .tbz2, .tar.bz2, .txz,
/// .tar.xz. `ending` is set to the kind, such as ".zip" or ".tar.gz".
bool is_archive_name(const std::string& path, std::string& ending);

/// A zip file, or a tar file, compressed or not, held in memory. Reading writes no files.
class Archive {
 public:
  /// Throws InputError for a file that is no such archive, is damaged, encrypted, empty, or holds
  /// links, devices, names that lead out of it, two members of one name, more than 256 MB, or more
  /// than 100,000 members.
  explicit Archive(const std::string& path);

  const std::vector<ArchiveMember>& members() const { return members_; }
  const std::string& sha256() const { return sha256_; }

  /// The bytes of an archive of the same kind with the same members in the same order. `changed`:
  /// new contents of members, by path. Throws InputError where a name cannot be written.
  std::string with(const std::map<std::string, std::string>& changed) const;

 private:
  std::string file_, sha256_;
  std::vector<ArchiveMember> members_;
  int format_ = 0, filter_ = 0;
};

}  // namespace armtrue
