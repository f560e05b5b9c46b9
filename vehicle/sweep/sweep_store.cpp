#include "vehicle/sweep/sweep_store.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <unordered_map>

#include "data/input_error.h"
#include "reports/csv.h"

namespace uiclink {
namespace {

namespace fs = std::filesystem;

constexpr const char* kSchema = "wagon-sweep/1";

/// Column names and messages are ours; quotes all the same, since some ("set") are words of SQL.
std::string Quote(const std::string& name) { return "\"" + name + "\""; }

std::vector<std::string> TextColumn(Sqlite* database, const std::string& sql) {
  SqliteStatement query(database, sql);
  std::vector<std::string> texts;
  while (query.Step()) texts.push_back(query.Text(0));
  return texts;
}

/// Whether the file is one that this program wrote, so that it may be added to or replaced.
/// @return false for one in which nothing stands yet: its process was killed, or is about to write.
bool CheckIsStore(const fs::path& path, Sqlite* database) {
  std::vector<std::string> schema;
  try {
    if (TextColumn(database, "SELECT name FROM sqlite_master").empty()) return false;
    schema = TextColumn(database, "SELECT value FROM campaign WHERE key = 'schema'");
  } catch (const SqliteError&) {  // no database, or another one
  }
  if (schema != std::vector<std::string>{kSchema})
    throw InputError(path.string(), 0,
                     fmt::format("expected a store of wagon sweep ({}), found another file", kSchema));
  return true;
}

/// Null for a store in which nothing stands yet.
std::unique_ptr<Sqlite> OpenToRead(const fs::path& path) {
  if (!fs::exists(path)) throw InputError(path.string(), 0, "expected a store of wagon sweep, found nothing");
  // Not read-only: a log that a killed process has left behind has to be taken in.
  auto database = std::make_unique<Sqlite>(path, Sqlite::Mode::kReadWrite);
  return CheckIsStore(path, database.get()) ? std::move(database) : nullptr;
}

void RemoveStore(const fs::path& path) {
  if (!fs::exists(path)) return;
  CheckIsStore(path, std::make_unique<Sqlite>(path, Sqlite::Mode::kReadWrite).get());
  for (const char* const end : {"-wal", "-shm", ""}) fs::remove(path.string() + end);
}

std::string AxisColumn(std::size_t axis) {
  const SweepAxis& known = SweepAxes()[axis];
  return Quote(known.name) + (known.IsNumber() ? " REAL" : " TEXT");
}

std::string Describe(const std::string& what, const std::string& was, const std::string& is) {
  return fmt::format("{} was \"{}\", is \"{}\"", what, was, is);
}

}  // namespace

std::size_t StoreCounts::total() const { return std::accumulate(by_status.begin(), by_status.end(), std::size_t{0}); }

SweepStore::SweepStore(const fs::path& path, const SweepPlan& plan, const std::string& version, Existing existing)
    : path_(path), plan_(plan), lock_(path), axes_(plan.ShownAxes()) {
  if (existing == Existing::kReplace) RemoveStore(path);
  database_ = std::make_unique<Sqlite>(path, Sqlite::Mode::kCreate);
  const bool is_new = !CheckIsStore(path, database_.get());
  // A log beside the file: a commit is an append, without a wait for the disk.
  database_->Execute("PRAGMA journal_mode = WAL");
  database_->Execute("PRAGMA synchronous = NORMAL");
  ids_.reserve(plan.size());
  for (std::size_t run = 0; run < plan.size(); ++run) ids_.push_back(plan.Id(run));
  SqliteTransaction transaction(database_.get());
  if (is_new) {
    Create();
  } else {
    Compare(version);
    Extend();
  }
  WriteCampaign(version);
  transaction.Commit();

  std::string columns = "id, run, status, reason, sample", marks = "?, ?, ?, ?, ?";
  const auto add = [&](const std::string& name) { columns += ", " + Quote(name), marks += ", ?"; };
  for (const std::size_t axis : axes_) add(SweepAxes()[axis].name);
  std::ranges::for_each(plan.drawn_columns(), add);
  for (const ResultColumn& column : plan.campaign().kind->columns()) add(column.name);
  insert_ = std::make_unique<SqliteStatement>(
      database_.get(), fmt::format("INSERT OR IGNORE INTO runs ({}, wall_s) VALUES ({}, ?)", columns, marks));
}

void SweepStore::Create() {
  std::string columns;
  for (const std::size_t axis : axes_) columns += AxisColumn(axis) + ", ";
  for (const std::string& drawn : plan_.drawn_columns()) columns += Quote(drawn) + " REAL, ";
  for (const ResultColumn& column : plan_.campaign().kind->columns())
    columns += Quote(column.name) + (column.integer ? " INTEGER, " : " REAL, ");
  database_->Execute("CREATE TABLE campaign (key TEXT PRIMARY KEY, value TEXT)");
  database_->Execute("CREATE TABLE input_files (role TEXT, name TEXT, path TEXT, sha256 TEXT)");
  database_->Execute(
      "CREATE TABLE runs (id TEXT PRIMARY KEY, run INTEGER, status TEXT NOT NULL, reason TEXT, sample INTEGER, " +
      columns + "wall_s REAL) WITHOUT ROWID");
  missing_.resize(plan_.size());
  std::iota(missing_.begin(), missing_.end(), std::size_t{0});
}

void SweepStore::Compare(const std::string& version) {
  std::unordered_map<std::string, std::size_t> planned;
  for (std::size_t run = 0; run < ids_.size(); ++run) planned.emplace(ids_[run], run);
  std::vector<bool> done(ids_.size());
  std::size_t rows = 0, strangers = 0;
  for (const std::string& id : TextColumn(database_.get(), "SELECT id FROM runs")) {
    const auto found = planned.find(id);
    ++rows;
    if (found == planned.end()) {
      ++strangers;
    } else {
      done[found->second] = true;
    }
  }
  const std::vector<std::string> begun =
      TextColumn(database_.get(), "SELECT value FROM campaign WHERE key = 'version'");
  if (strangers > 0 || (rows > 0 && begun != std::vector<std::string>{version})) {
    std::string message = strangers > 0
                              ? fmt::format(
                                    "expected the campaign that the store was begun with, found {} of its {} "
                                    "runs not in it any more",
                                    strangers, rows)
                              : std::string("expected the version that the store was begun with, found another one");
    for (const std::string& change : FindChanges(version)) message += "\n  " + change;
    throw InputError(path_.string(), 0,
                     message + "\n  Undo the change, give another --store, or throw its runs away with --restart.");
  }
  for (std::size_t run = 0; run < done.size(); ++run)
    if (!done[run]) missing_.push_back(run);
}

std::vector<std::string> SweepStore::FindChanges(const std::string& version) {
  std::vector<std::string> changes;
  const auto compare = [&](const std::string& key, const std::string& what, const std::string& is) {
    const std::vector<std::string> was =
        TextColumn(database_.get(), "SELECT value FROM campaign WHERE key = '" + key + "'");
    if (!was.empty() && was[0] != is) changes.push_back(Describe(what, was[0], is));
  };
  compare("version", "version of the program", version);
  compare("run", "[run]", plan_.campaign().kind->Identity());
  compare("seed", "seed", std::to_string(plan_.campaign().seed));
  SqliteStatement files(database_.get(), "SELECT role, path, sha256 FROM input_files");
  while (files.Step()) {
    for (const InputFile& file : plan_.files()) {
      if (file.role == files.Text(0) && file.path == files.Text(1) && file.sha256 != files.Text(2))
        changes.push_back(fmt::format("{} has changed: sha256 was {}, is {}", file.path, files.Text(2), file.sha256));
    }
  }
  if (changes.empty()) changes.emplace_back("values in [base], [grid] or [sample] have changed or gone");
  return changes;
}

/// Runs keep their rows when the campaign grows; their numbers move, and new axes get the value that they had.
void SweepStore::Extend() {
  const std::vector<std::string> before = TextColumn(database_.get(), "SELECT name FROM pragma_table_info('runs')");
  const auto add = [&](const std::string& name, const std::string& column) {
    if (std::ranges::find(before, name) == before.end()) database_->Execute("ALTER TABLE runs ADD COLUMN " + column);
  };
  for (const std::size_t axis : axes_) add(SweepAxes()[axis].name, AxisColumn(axis));
  for (const std::string& drawn : plan_.drawn_columns()) add(drawn, Quote(drawn) + " REAL");
  const std::vector<std::string> text = TextColumn(database_.get(), "SELECT value FROM campaign WHERE key = 'text'");
  if (text == std::vector<std::string>{plan_.campaign().text}) return;
  std::string columns = "run = ?";
  for (const std::size_t axis : axes_) columns += ", " + Quote(SweepAxes()[axis].name) + " = ?";
  for (const std::string& drawn : plan_.drawn_columns()) columns += ", " + Quote(drawn) + " = ?";
  SqliteStatement update(database_.get(), "UPDATE runs SET " + columns + " WHERE id = ?");
  for (std::size_t run = 0; run < ids_.size(); ++run) {
    update.Bind(static_cast<std::int64_t>(run));
    BindAxes(&update, run);
    update.Bind(ids_[run]).Execute();
  }
}

void SweepStore::WriteCampaign(const std::string& version) {
  const Campaign& campaign = plan_.campaign();
  SqliteStatement put(database_.get(), "INSERT OR REPLACE INTO campaign VALUES (?, ?)");
  const std::vector<std::pair<std::string, std::string>> entries{{"schema", kSchema},
                                                                 {"version", version},
                                                                 {"name", campaign.name},
                                                                 {"seed", std::to_string(campaign.seed)},
                                                                 {"run", campaign.kind->Identity()},
                                                                 {"runs", std::to_string(plan_.size())},
                                                                 {"text", campaign.text}};
  for (const auto& [key, value] : entries) put.Bind(key).Bind(value).Execute();
  database_->Execute("DELETE FROM input_files");
  SqliteStatement file(database_.get(), "INSERT INTO input_files VALUES (?, ?, ?, ?)");
  for (const InputFile& input : plan_.files())
    file.Bind(input.role).Bind(input.name).Bind(input.path).Bind(input.sha256).Execute();
}

void SweepStore::BindAxes(SqliteStatement* statement, std::size_t run) const {
  const std::vector<std::optional<AxisValue>> values = plan_.Values(run);
  for (const std::size_t axis : axes_) {
    if (!values[axis]) {
      statement->BindNull();
    } else if (const auto* number = std::get_if<double>(&*values[axis])) {
      statement->Bind(*number);
    } else {
      statement->Bind(std::get<std::string>(*values[axis]));
    }
  }
  for (const std::optional<double>& drawn : plan_.Drawn(run)) drawn ? statement->Bind(*drawn) : statement->BindNull();
}

void SweepStore::Write(const std::vector<FinishedRun>& runs) {
  SqliteTransaction transaction(database_.get());
  const std::vector<ResultColumn>& columns = plan_.campaign().kind->columns();
  for (const FinishedRun& done : runs) {
    insert_->Bind(ids_[done.run]).Bind(static_cast<std::int64_t>(done.run)).Bind(Name(done.outcome.status));
    done.outcome.reason.empty() ? insert_->BindNull() : insert_->Bind(done.outcome.reason);
    const std::optional<std::uint32_t> sample = plan_.Sample(done.run);
    sample ? insert_->Bind(static_cast<std::int64_t>(*sample)) : insert_->BindNull();
    BindAxes(insert_.get(), done.run);
    for (std::size_t i = 0; i < columns.size(); ++i) {
      const bool known = i < done.outcome.values.size() && std::isfinite(done.outcome.values[i]);
      if (!known) {
        insert_->BindNull();
      } else if (columns[i].integer) {
        insert_->Bind(static_cast<std::int64_t>(done.outcome.values[i]));
      } else {
        insert_->Bind(done.outcome.values[i]);
      }
    }
    insert_->Bind(done.wall_s).Execute();
  }
  transaction.Commit();
}

StoreCounts SweepStore::Count(const fs::path& path) {
  const std::unique_ptr<Sqlite> database = OpenToRead(path);
  StoreCounts counts;
  if (!database) return counts;
  SqliteStatement query(database.get(), "SELECT status, coalesce(reason, ''), count(*) FROM runs GROUP BY 1, 2");
  while (query.Step()) {
    const auto rows = static_cast<std::size_t>(query.Integer(2));
    for (int status = 0; status < kRunStatuses; ++status) {
      if (query.Text(0) == Name(static_cast<RunStatus>(status)))
        counts.by_status[static_cast<std::size_t>(status)] += rows;
    }
    if (query.Text(0) == Name(RunStatus::kFailed)) counts.reasons[query.Text(1)] += rows;
  }
  return counts;
}

std::string SweepStore::FormatCsv(const fs::path& path) {
  const std::unique_ptr<Sqlite> database = OpenToRead(path);
  std::string csv;
  if (!database) return csv;
  SqliteStatement query(database.get(), "SELECT * FROM runs ORDER BY run");
  for (int i = 0; i < query.size(); ++i) csv += (i > 0 ? "," : "") + CsvCell(query.Name(i));
  csv += '\n';
  while (query.Step()) {
    for (int i = 0; i < query.size(); ++i) {
      if (i > 0) csv += ',';
      if (query.IsText(i)) csv += CsvCell(query.Text(i));
      if (query.IsInteger(i)) csv += fmt::format("{}", query.Integer(i));
      if (!query.IsText(i) && !query.IsInteger(i) && !query.IsNull(i)) csv += fmt::format("{}", query.Number(i));
    }
    csv += '\n';
  }
  return csv;
}

}  // namespace uiclink
