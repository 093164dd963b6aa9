#include <algorithm>
#include <array>
#include <map>
#include <set>
#include <string>
#include <unordered_map>
#include <utility>

#include "programs/abb/rapid_calls.h"
#include "programs/abb/rapid_flow.h"
#include "programs/abb/rapid_parts.h"
#include "programs/abb/rapid_words.h"
#include "programs/statement.h"
#include "programs/text_cursor.h"

namespace armtrue {
namespace {

// What statements do to a datum.
struct Uses {
  int named = 0;
  int assigned = 0;
  int handed = 0;  // to what may change it

  void add(const Uses& other, int sign) {
    named += sign * other.named;
    assigned += sign * other.assigned;
    handed += sign * other.handed;
  }
};

// By modules that declare the name, and by modules that do not: if the program declares the name
// itself, a module that declares it, too, means another datum.
using UsesOfName = std::array<Uses, 2>;

struct Module {
  const ProgramText* text = nullptr;
  std::string plain;  // by masked()
  std::vector<Statement> statements;
  std::set<std::string> words, routines;
  std::set<std::string> declared;   // anywhere
  std::set<std::string> of_module;  // outside of routines
  std::set<std::string> global;     // of these, those that are not LOCAL
  std::unordered_map<std::string, Uses> uses;
};

class RapidFolder : public FolderTexts {
 public:
  explicit RapidFolder(const std::vector<const ProgramText*>& modules) {
    for (const ProgramText* const text : modules) {
      Module& module = modules_.emplace_back();
      module.text = text;
      read_names(module);
    }
    for (size_t i = 0; i < modules_.size(); ++i) {
      for (const std::string& name : modules_[i].global) declaring_[name].insert(i);
      for (const std::string& name : modules_[i].routines) having_routine_[name].insert(i);
    }
    std::vector<RapidModuleText> texts;
    for (const Module& module : modules_) texts.push_back({module.plain, module.statements});
    displacements_ = follow_rapid_displacements(texts);
    for (const Module& module : modules_) routines_.read(module.plain, module.statements);
    routines_.follow_calls();
    for (Module& module : modules_) {
      read_uses(module);
      for (const auto& [name, uses] : module.uses)
        uses_[name][module.declared.contains(name)].add(uses, 1);
      module.plain.clear();
      module.statements.clear();
    }
  }

  std::vector<ProgramText> for_program(const std::vector<const ProgramText*>& own) const override {
    const auto found = std::ranges::find_if(modules_, [&](const Module& module) {
      return std::ranges::find(own, module.text) != own.end();
    });
    if (found == modules_.end()) return {};
    const Module& program = *found;
    const std::set<size_t> whole = modules_that_declare_for(program);
    std::vector<ProgramText> result;
    for (const size_t module : whole) result.push_back(*modules_[module].text);
    result.push_back({kRapidOthers, what_others_do_to(program, whole)});
    return result;
  }

 private:
  using Places = std::map<std::string, std::set<size_t>>;  // modules, by names

  // As RapidData reads a module of others.
  void read_names(Module& module) {
    module.plain = masked(module.text->text, '!', "\"");
    module.statements = split_statements(module.plain, ';');
    each_word(
        module.plain, {0, 0, module.plain.size()},
        [&](const std::string& word, size_t, const TextCursor&) { module.words.insert(word); });
    bool is_in_routine = false;
    for (const Statement& statement : module.statements) {
      std::string before;
      each_rapid_word(
          module.plain, statement, [&](const std::string& word, size_t, TextCursor cursor) {
            is_in_routine =
                (is_in_routine || begins_rapid_routine(word)) && !ends_rapid_routine(word);
            if (TextCursor head = cursor; begins_rapid_routine(word))
              module.routines.insert(take_rapid_routine(word, head));
            const bool is_local = std::exchange(before, word) == "LOCAL";
            if (!is_rapid_declaration(word)) return false;
            const std::string type = cursor.take_name(), name = cursor.take_name();
            if (name.empty()) return false;
            module.declared.insert(name);
            if (!is_in_routine) types_.emplace(name, type);
            if (!is_in_routine) module.of_module.insert(name);
            if (!is_in_routine && !is_local) module.global.insert(name);
            return false;
          });
    }
  }

  void read_uses(Module& module) const {
    each_rapid_use(module.plain, module.statements,
                   [&](const Statement& statement, const std::string& word, size_t at,
                       const TextCursor& cursor) {
                     Uses& uses = module.uses[word];
                     ++uses.named;
                     if (TextCursor ahead = cursor; takes_rapid_assignment(ahead))
                       ++uses.assigned;
                     else if (may_be_changed(module, statement, word, at, cursor))
                       ++uses.handed;
                   });
  }

  bool may_be_changed(const Module& module, const Statement& statement, const std::string& name,
                      size_t at, TextCursor behind) const {
    const auto type = types_.find(name);
    if (type == types_.end()) return false;
    const std::string receiver = rapid_receiver(module.plain, statement, at, behind);
    return !receiver.empty() &&
           routines_.may_change(receiver, rapid_type_of_part(type->second, behind));
  }

  // The modules whose global data a program names and does not declare itself.
  std::set<size_t> modules_that_declare_for(const Module& program) const {
    std::set<size_t> whole;
    for (const std::string& word : program.words) {
      const auto found = declaring_.find(word);
      if (found == declaring_.end() || program.of_module.contains(word)) continue;
      for (const size_t module : found->second)
        if (&modules_[module] != &program) whole.insert(module);
    }
    return whole;
  }

  // A module that changes the same data as all others, except those that the program has whole.
  std::string what_others_do_to(const Module& program, const std::set<size_t>& whole) const {
    const auto is_by_others = [&](const Places& places, const std::string& name) {
      const auto found = places.find(name);
      return found != places.end() && std::ranges::any_of(found->second, [&](size_t module) {
               return &modules_[module] != &program && !whole.contains(module);
             });
    };
    std::string text = "MODULE others\n";
    for (const std::string& word : program.words) {
      const auto leaving = displacements_.leaving.find(word);
      if (leaving != displacements_.leaving.end() && !program.routines.contains(word))
        text += routine_of_others(word, displacement_of(leaving->second));
      else if (is_by_others(having_routine_, word))
        text += routine_of_others(word, "");
      const bool is_own = program.of_module.contains(word);
      const auto total = uses_.find(word);
      if (total == uses_.end() || (!is_own && !declaring_.contains(word))) continue;
      UsesOfName uses = total->second;
      subtract(program, word, uses);
      for (const size_t module : whole) subtract(modules_[module], word, uses);
      if (!is_own) uses[0].add(uses[1], 1);
      text += statements_of(word, uses[0]);
    }
    return text + displaced_calls_of(program) + "ENDMODULE\n";
  }

  // A routine that changes arguments of the same types.
  std::string routine_of_others(const std::string& name, const std::string& body) const {
    std::string parameters, assignments;
    for (const std::string& type : routines_.changed_by(name)) {
      const std::string of_type = "of_" + type;
      parameters += (parameters.empty() ? "INOUT " : ",INOUT ") + type + " " + of_type;
      assignments += of_type + ":=0;\n";
    }
    return "PROC " + name + "(" + parameters + ")\n" + assignments + body + "ENDPROC\n";
  }

  // A statement that leaves one of these.
  static std::string displacement_of(const std::set<int>& values) {
    if (values == std::set<int>{0}) return "PDispOff;\n";
    return values == std::set<int>{1} ? "PDispSet;\n" : "IF TRUE PDispSet;\n";
  }

  // Routines of others, without a name of RAPID, that call those of a program with displacements.
  std::string displaced_calls_of(const Module& program) const {
    std::string text;
    for (const std::string& routine : program.routines) {
      const auto called = displacements_.called_with.find(routine);
      if (called == displacements_.called_with.end() || called->second == std::set<int>{0})
        continue;
      for (const int value : called->second)
        text += "PROC $()\n" + displacement_of({value}) + routine + ";\nPDispOff;\nENDPROC\n";
    }
    return text;
  }

  static void subtract(const Module& module, const std::string& name, UsesOfName& uses) {
    if (const auto found = module.uses.find(name); found != module.uses.end())
      uses[module.declared.contains(name)].add(found->second, -1);
  }

  // Twice counts as any number of times.
  static std::string statements_of(const std::string& name, const Uses& uses) {
    std::string text;
    if (uses.named > 0) text += "MoveJ " + name + ";\n";
    for (int i = 0; i < std::min(uses.assigned, 2); ++i) text += name + ":=0;\n";
    if (uses.handed > 0) text += "Incr " + name + ".x;\n";
    return text;
  }

  std::vector<Module> modules_;
  RapidDisplacements displacements_;
  RapidRoutines routines_;
  std::map<std::string, std::string> types_;  // of data outside of routines
  Places declaring_;  // global data
  Places having_routine_;
  std::map<std::string, UsesOfName> uses_;
};

}  // namespace

std::unique_ptr<FolderTexts> rapid_folder(const std::vector<const ProgramText*>& modules) {
  return std::make_unique<RapidFolder>(modules);
}

}  // namespace armtrue
