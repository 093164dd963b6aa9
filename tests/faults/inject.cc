// inject FOLDER CALL FAULT REPORT COMMAND [ARGUMENT]...: runs a command and makes one of its system
// calls fail, by ptrace. Counted are the calls that open, read, write, synchronise, close, rename,
// make or remove something in FOLDER, and those that write to standard output or error. FAULT: the
// number of an error, such as 28 (ENOSPC), which call CALL returns instead of being made; or 0: the
// process is killed before it. CALL 0 lets all pass. The names of the calls are written to REPORT,
// one on each line. Exit code: that of the command, 128 + n if a signal n ended it.

#include <sys/ptrace.h>
#include <sys/syscall.h>
#include <sys/user.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <map>
#include <set>
#include <string>

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
           PTRACE_O_TRACESYSGOOD | PTRACE_O_TRACECLONE | PTRACE_O_EXITKILL);
    ptrace(PTRACE_SYSCALL, child, nullptr, nullptr);
    while (true) {
      const pid_t thread = waitpid(-1, &status, __WALL);
      if (thread < 0) return 99;
      if (WIFEXITED(status) || WIFSIGNALED(status)) {
        if (thread == child)
          return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
        continue;
      }
      int signal = 0;
      if (WSTOPSIG(status) == (SIGTRAP | 0x80))
        at_call(thread);
      else if (WSTOPSIG(status) != SIGTRAP && WSTOPSIG(status) != SIGSTOP)
        signal = WSTOPSIG(status);
      ptrace(PTRACE_SYSCALL, thread, nullptr, signal);
    }
  }

 private:
  struct Running {
    bool is_inside = false, opens_here = false, fails = false;
    Number number = 0;
  };

  void at_call(pid_t thread) {
    user_regs_struct registers{};
    ptrace(PTRACE_GETREGS, thread, nullptr, &registers);
    Running& running = running_[thread];
    running.is_inside = !running.is_inside;
    if (running.is_inside)
      enter(thread, registers, running);
    else
      leave(thread, registers, running);
  }

  bool is_here(pid_t thread, const Call& call, const user_regs_struct& registers) const {
    if (call.of_file) return files_.contains(registers.rdi);
    const std::string path = text_at(thread, argument(registers, call.path));
    return path.starts_with(folder_) || (!path.empty() && path[0] != '/');
  }

  void enter(pid_t thread, user_regs_struct& registers, Running& running) {
    running = {true, false, false, registers.orig_rax};
    const auto known = kCalls.find(registers.orig_rax);
    if (known == kCalls.end() || !is_here(thread, known->second, registers)) return;
    std::fprintf(report_, "%s\n", known->second.name);
    if (++count_ == fault_at_) {
      std::fflush(report_);
      if (fault_ == 0) {
        kill(child_, SIGKILL);
        return;
      }
      running.fails = true;
      registers.orig_rax = ~Number{0};  // no such call: the kernel does nothing
      ptrace(PTRACE_SETREGS, thread, nullptr, &registers);
      return;
    }
    running.opens_here = std::string(known->second.name) == "open";
    if (registers.orig_rax == SYS_close) files_.erase(registers.rdi);
  }

  void leave(pid_t thread, user_regs_struct& registers, const Running& running) {
    if (running.fails) {
      registers.rax = static_cast<Number>(-fault_);
      ptrace(PTRACE_SETREGS, thread, nullptr, &registers);
    } else if (running.opens_here && static_cast<long long>(registers.rax) >= 0) {
      files_.insert(registers.rax);
    }
  }

  std::string folder_;
  int fault_at_, fault_;
  std::FILE* report_;
  pid_t child_ = 0;
  int count_ = 0;
  std::map<pid_t, Running> running_;
  std::set<Number> files_{STDOUT_FILENO, STDERR_FILENO};  // descriptors whose calls count
};

}  // namespace

int main(int argc, char** argv) {
  if (argc < 6) return 98;
  std::FILE* const report = std::fopen(argv[4], "w");
  if (!report) return 98;
  const pid_t child = fork();
  if (child == 0) {
    ptrace(PTRACE_TRACEME, 0, nullptr, nullptr);
    raise(SIGSTOP);
    execv(argv[5], argv + 5);
    _exit(97);
  }
  const int code = Tracer(argv[1], std::atoi(argv[2]), std::atoi(argv[3]), report).run(child);
  std::fclose(report);
  return code;
}
