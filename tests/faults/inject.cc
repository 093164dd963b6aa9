// inject FOLDER CALL FAULT REPORT COMMAND [ARGUMENT]...: runs a command and makes one of its system
// calls fail, by ptrace; a seccomp filter stops only at calls of the kinds counted. Counted are the
// calls that open, read, write, synchronise, close, rename, make or remove something in FOLDER, and
// those that write to standard output or error. FAULT: the number of an error, such as 28 (ENOSPC),
// which call CALL returns instead of being made; or 0: the process is killed before it. CALL 0 lets
// all pass. The names of the calls are written to REPORT, one on each line. Exit code: that of the
// command, 128 + n if a signal n ended it.

#include <linux/filter.h>
#include <linux/seccomp.h>
#include <sys/prctl.h>
#include <sys/ptrace.h>
#include <sys/syscall.h>
#include <sys/user.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <cstddef>
#include <cstdio>
#include <cstdlib>
#include <map>
#include <set>
#include <string>
#include <vector>

namespace {

using Number = unsigned long long;

struct Call {
  const char* name;
  int path = -1;         // argument that is a path; -1: none
  bool of_file = false;  // the first argument is a descriptor
};

const std::map<Number, Call> kCalls{
    {SYS_open, {"open", 0}},           {SYS_openat, {"open", 1}},
    {SYS_rename, {"rename", 0}},       {SYS_renameat, {"rename", 1}},
    {SYS_renameat2, {"rename", 1}},    {SYS_unlink, {"unlink", 0}},
    {SYS_unlinkat, {"unlink", 1}},     {SYS_mkdir, {"mkdir", 0}},
    {SYS_mkdirat, {"mkdir", 1}},       {SYS_rmdir, {"rmdir", 0}},
    {SYS_read, {"read", -1, true}},    {SYS_write, {"write", -1, true}},
    {SYS_writev, {"write", -1, true}}, {SYS_fsync, {"fsync", -1, true}},
    {SYS_close, {"close", -1, true}}};

Number argument(const user_regs_struct& at, int index) {
  const Number arguments[] = {at.rdi, at.rsi, at.rdx};
  return arguments[index];
}

std::string text_at(pid_t thread, Number address) {
  std::string text;
  while (text.size() < 4096) {
    const long word = ptrace(PTRACE_PEEKDATA, thread, address + text.size(), nullptr);
    for (size_t k = 0; k < sizeof word; ++k) {
      const char c = reinterpret_cast<const char*>(&word)[k];
      if (c == '\0') return text;
      text += c;
    }
  }
  return text;
}

class Tracer {
 public:
  Tracer(std::string folder, int fault_at, int fault, std::FILE* report)
      : folder_(std::move(folder)), fault_at_(fault_at), fault_(fault), report_(report) {}

  int run(pid_t child) {
    child_ = child;
    int status = 0;
    waitpid(child, &status, 0);
    ptrace(PTRACE_SETOPTIONS, child, nullptr,
           PTRACE_O_TRACESYSGOOD | PTRACE_O_TRACESECCOMP | PTRACE_O_TRACECLONE | PTRACE_O_EXITKILL);
    ptrace(PTRACE_CONT, child, nullptr, nullptr);
    while (true) {
      const pid_t thread = waitpid(-1, &status, __WALL);
      if (thread < 0) return 99;
      if (WIFEXITED(status) || WIFSIGNALED(status)) {
        if (thread == child)
          return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
        continue;
      }
      int signal = 0;
      bool is_awaited = false;
      if (status >> 8 == (SIGTRAP | PTRACE_EVENT_SECCOMP << 8))
        is_awaited = enter(thread);
      else if (WSTOPSIG(status) == (SIGTRAP | 0x80))
        leave_open(thread);
      else if (WSTOPSIG(status) != SIGTRAP && WSTOPSIG(status) != SIGSTOP)
        signal = WSTOPSIG(status);
      ptrace(is_awaited ? PTRACE_SYSCALL : PTRACE_CONT, thread, nullptr, signal);
    }
  }

 private:
  bool is_here(pid_t thread, const Call& call, const user_regs_struct& registers) const {
    if (call.of_file) return files_.contains(registers.rdi);
    const std::string path = text_at(thread, argument(registers, call.path));
    return path.starts_with(folder_) || (!path.empty() && path[0] != '/');
  }

  /// Before a call of kCalls. True: an open whose end is awaited, because its descriptor counts
  /// from then on.
  bool enter(pid_t thread) {
    user_regs_struct registers{};
    ptrace(PTRACE_GETREGS, thread, nullptr, &registers);
    const Call& call = kCalls.at(registers.orig_rax);
    if (!is_here(thread, call, registers)) return false;
    std::fprintf(report_, "%s\n", call.name);
    if (++count_ == fault_at_) {
      std::fflush(report_);
      if (fault_ == 0) {
        kill(child_, SIGKILL);
        return false;
      }
      registers.orig_rax = ~Number{0};  // no such call: the kernel does nothing, and returns rax
      registers.rax = static_cast<Number>(-fault_);
      ptrace(PTRACE_SETREGS, thread, nullptr, &registers);
      return false;
    }
    if (registers.orig_rax == SYS_close) files_.erase(registers.rdi);
    return std::string(call.name) == "open";
  }

  void leave_open(pid_t thread) {
    user_regs_struct registers{};
    ptrace(PTRACE_GETREGS, thread, nullptr, &registers);
    if (static_cast<long long>(registers.rax) >= 0) files_.insert(registers.rax);
  }

  std::string folder_;
  int fault_at_, fault_;
  std::FILE* report_;
  pid_t child_ = 0;
  int count_ = 0;
  std::set<Number> files_{STDOUT_FILENO, STDERR_FILENO};  // descriptors whose calls count
};

/// Of this process from here on: the calls of kCalls stop for the tracer, all others run at their
/// speed.
bool stop_at_calls() {
  std::vector<sock_filter> filter{BPF_STMT(BPF_LD | BPF_W | BPF_ABS, offsetof(seccomp_data, nr))};
  for (const auto& [number, call] : kCalls) {
    filter.push_back(BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, static_cast<unsigned>(number), 0, 1));
    filter.push_back(BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_TRACE));
  }
  filter.push_back(BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_ALLOW));
  const sock_fprog program{static_cast<unsigned short>(filter.size()), filter.data()};
  return prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0) == 0 &&
         prctl(PR_SET_SECCOMP, SECCOMP_MODE_FILTER, &program) == 0;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 6) return 98;
  std::FILE* const report = std::fopen(argv[4], "w");
  if (!report) return 98;
  const pid_t child = fork();
  if (child == 0) {
    ptrace(PTRACE_TRACEME, 0, nullptr, nullptr);
    raise(SIGSTOP);
    if (!stop_at_calls()) _exit(96);
    execv(argv[5], argv + 5);
    _exit(97);
  }
  const int code = Tracer(argv[1], std::atoi(argv[2]), std::atoi(argv[3]), report).run(child);
  std::fclose(report);
  return code;
}
