#pragma once

#include <sys/stat.h>
#include <unistd.h>

namespace armtrue {

/// Gives a file or folder the mode, owner and group of the one that it replaces. Where the process
/// may not set the owner or the group, the set-ID bits are left out; if it may not set the group,
/// the group gets no more rights than all others. Returns false if the mode cannot be set; errno
/// says why.
inline bool give_rights(int descriptor, const struct stat& old) {
  struct stat now {};
  if (fstat(descriptor, &now) != 0) return false;
  mode_t mode = old.st_mode & 07777;
  const bool has_owner = now.st_uid == old.st_uid || fchown(descriptor, old.st_uid, -1) == 0;
  const bool has_group = now.st_gid == old.st_gid || fchown(descriptor, -1, old.st_gid) == 0;
  if (!has_owner) mode &= ~S_ISUID;
  if (!has_group) mode &= ~(S_ISGID | (S_IRWXG & ~(mode << 3)));
  return fchmod(descriptor, mode) == 0;
}

}  // namespace armtrue
