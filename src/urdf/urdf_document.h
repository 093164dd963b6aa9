#pragma once

#include <tinyxml.h>
#include <urdf_model/model.h>
#include <urdf_world/types.h>

#include <string>

namespace armtrue {

/// A URDF that is a tree of links, without macros, with masses that are numbers.
class UrdfDocument {
 public:
  /// Reads the text with urdfdom. `file` is for messages. Throws InputError for any other text.
  UrdfDocument(const std::string& text, const std::string& file);

  const std::string& file() const { return file_; }
  const urdf::ModelInterface& model() const { return *model_; }
  /// The file and, if it is found, the line of a joint, for messages.
  std::string place_of_joint(const std::string& joint) const;

 private:
  std::string file_;
  TiXmlDocument document_;
  urdf::ModelInterfaceSharedPtr model_;
};

}  // namespace armtrue
