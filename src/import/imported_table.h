#pragma once

#include <string>

#include "armtrue/import/import_io.h"
#include "import/column_mapping.h"
#include "import/plain_table.h"

namespace armtrue {

/// A table that is read, and the quantities of its columns.
struct ImportedTable {
  ImportNames names;
  PlainTable table;
  ColumnMapping mapping;
};

/// Reads a table or a recording, its columns not mapped yet. Throws InputError.
ImportedTable read_imported_table(const std::string& path, const ImportOptions& options,
                                  TableRole role);

/// Maps its columns. Throws InputError.
void map_imported_table(ImportedTable& import, const ImportOptions& options, TableRole role);

}  // namespace armtrue
