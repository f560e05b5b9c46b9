#include "vehicle/sweep/sqlite.h"

#include <sqlite3.h>

#include <cmath>

namespace uiclink {

Sqlite::Sqlite(const std::filesystem::path& path, Mode mode) : path_(path.string()) {
  const int flags = mode == Mode::kReadOnly    ? SQLITE_OPEN_READONLY
                    : mode == Mode::kReadWrite ? SQLITE_OPEN_READWRITE
                                               : SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE;
  if (sqlite3_open_v2(path_.c_str(), &database_, flags, nullptr) != SQLITE_OK) {
    const std::string what = database_ ? sqlite3_errmsg(database_) : "out of memory";
    sqlite3_close(database_);
    throw SqliteError(path_ + ": " + what);
  }
  constexpr int kPatience_ms = 10000;
  sqlite3_busy_timeout(database_, kPatience_ms);
  sqlite3_extended_result_codes(database_, 1);
}

Sqlite::~Sqlite() { sqlite3_close(database_); }

void Sqlite::Execute(const std::string& sql) {
  if (sqlite3_exec(database_, sql.c_str(), nullptr, nullptr, nullptr) != SQLITE_OK) Throw(sql);
}

void Sqlite::Throw(const std::string& what) const {
  throw SqliteError(path_ + ": " + sqlite3_errmsg(database_) + " (" + what.substr(0, 60) + ")");
}

SqliteStatement::SqliteStatement(Sqlite* database, const std::string& sql) : database_(database) {
  Check(sqlite3_prepare_v2(database->database_, sql.c_str(), -1, &statement_, nullptr));
}

SqliteStatement::~SqliteStatement() { sqlite3_finalize(statement_); }

void SqliteStatement::Check(int code) {
  if (code != SQLITE_OK) database_->Throw(statement_ ? sqlite3_sql(statement_) : "prepare");
}

SqliteStatement& SqliteStatement::Bind(std::string_view text) {
  Check(sqlite3_bind_text64(statement_, ++bound_, text.data(), text.size(), SQLITE_TRANSIENT, SQLITE_UTF8));
  return *this;
}

SqliteStatement& SqliteStatement::Bind(std::int64_t number) {
  Check(sqlite3_bind_int64(statement_, ++bound_, number));
  return *this;
}

SqliteStatement& SqliteStatement::Bind(double number) {
  if (!std::isfinite(number)) return BindNull();
  Check(sqlite3_bind_double(statement_, ++bound_, number));
  return *this;
}

SqliteStatement& SqliteStatement::BindNull() {
  Check(sqlite3_bind_null(statement_, ++bound_));
  return *this;
}

bool SqliteStatement::Step() {
  const int code = sqlite3_step(statement_);
  if (code != SQLITE_ROW && code != SQLITE_DONE) Check(code);
  return code == SQLITE_ROW;
}

void SqliteStatement::Execute() {
  while (Step()) {
  }
  Reset();
}

void SqliteStatement::Reset() {
  sqlite3_reset(statement_);
  bound_ = 0;
}

int SqliteStatement::size() const { return sqlite3_column_count(statement_); }
std::string SqliteStatement::Name(int column) const { return sqlite3_column_name(statement_, column); }
bool SqliteStatement::IsNull(int column) const { return sqlite3_column_type(statement_, column) == SQLITE_NULL; }
bool SqliteStatement::IsText(int column) const { return sqlite3_column_type(statement_, column) == SQLITE_TEXT; }
bool SqliteStatement::IsInteger(int column) const { return sqlite3_column_type(statement_, column) == SQLITE_INTEGER; }
std::int64_t SqliteStatement::Integer(int column) const { return sqlite3_column_int64(statement_, column); }
double SqliteStatement::Number(int column) const { return sqlite3_column_double(statement_, column); }

std::string SqliteStatement::Text(int column) const {
  const auto* const text = reinterpret_cast<const char*>(sqlite3_column_text(statement_, column));
  return text ? std::string(text, static_cast<std::size_t>(sqlite3_column_bytes(statement_, column))) : "";
}

SqliteTransaction::SqliteTransaction(Sqlite* database) : database_(database) { database->Execute("BEGIN IMMEDIATE"); }

SqliteTransaction::~SqliteTransaction() {
  if (!open_) return;
  try {
    database_->Execute("ROLLBACK");
  } catch (const SqliteError&) {  // what made it fail is on its way up already
  }
}

void SqliteTransaction::Commit() {
  database_->Execute("COMMIT");
  open_ = false;
}

}  // namespace uiclink
