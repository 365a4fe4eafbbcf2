-- Tables of results.duckdb. Values are SI; decibels exist only in views. Every column's unit stands in its comment.

CREATE TABLE schema_version (version INTEGER NOT NULL, name VARCHAR NOT NULL, form VARCHAR);
COMMENT ON TABLE schema_version IS 'Migrations applied to this file, one row each';
COMMENT ON COLUMN schema_version.version IS 'Number of the migration';
COMMENT ON COLUMN schema_version.name IS 'Name of the migration';
COMMENT ON COLUMN schema_version.form IS 'sha256 of the SQL of all tables and views of this file';

CREATE TABLE snapshot (fingerprint VARCHAR NOT NULL, results VARCHAR NOT NULL);
COMMENT ON TABLE snapshot IS 'What this file was derived from, one row';
COMMENT ON COLUMN snapshot.fingerprint IS 'sha256 over the records and runs that were there; an unchanged one makes an ingest do nothing';
COMMENT ON COLUMN snapshot.results IS 'sha256 over what levels and figures depend on; a run that adds nothing leaves it as it is';

CREATE TABLE ingested (unit_id VARCHAR NOT NULL, key VARCHAR NOT NULL);
COMMENT ON TABLE ingested IS 'Units whose arrays have rows in series, psd_lines, bands or receptances';
COMMENT ON COLUMN ingested.unit_id IS 'Unit, see units';
COMMENT ON COLUMN ingested.key IS 'sha256 over what else the rows depend on: cases, names and output.narrow_band of the study';

CREATE TABLE runs (
    run_id VARCHAR NOT NULL, sequence INTEGER NOT NULL, study VARCHAR, reference VARCHAR, model_version VARCHAR,
    host VARCHAR, host_class VARCHAR, threads INTEGER, started TIMESTAMP, finished TIMESTAMP, exit_status INTEGER,
    versions VARCHAR, resolved_study VARCHAR
);
COMMENT ON TABLE runs IS 'One row per run of the study in this directory';
COMMENT ON COLUMN runs.run_id IS 'Identity of the run';
COMMENT ON COLUMN runs.sequence IS 'Order of the runs, 1 is the oldest';
COMMENT ON COLUMN runs.study IS 'Name of the study';
COMMENT ON COLUMN runs.reference IS 'Approach that the others are compared with';
COMMENT ON COLUMN runs.model_version IS 'Version of the physical model';
COMMENT ON COLUMN runs.host IS 'Name of the machine that drove the run';
COMMENT ON COLUMN runs.host_class IS 'Kind of machine; run times are compared within one kind only';
COMMENT ON COLUMN runs.threads IS 'Computing threads per worker';
COMMENT ON COLUMN runs.started IS 'Start, UTC';
COMMENT ON COLUMN runs.finished IS 'End, UTC; NULL while running or after an interruption';
COMMENT ON COLUMN runs.exit_status IS '0 done, 1 some tasks failed; NULL while running or after an interruption';
COMMENT ON COLUMN runs.versions IS 'Versions of the software, JSON';
COMMENT ON COLUMN runs.resolved_study IS 'The study as it was understood, JSON';

CREATE TABLE run_cases (run_id VARCHAR NOT NULL, case_id VARCHAR NOT NULL);
COMMENT ON TABLE run_cases IS 'Which cases each run asked for';
COMMENT ON COLUMN run_cases.run_id IS 'Run, see runs';
COMMENT ON COLUMN run_cases.case_id IS 'Case, see cases';

CREATE TABLE cases (
    case_id VARCHAR NOT NULL, soil VARCHAR, track VARCHAR, train VARCHAR, unevenness VARCHAR, speed_kmh DOUBLE,
    soil_id VARCHAR, track_id VARCHAR, train_id VARCHAR, unevenness_id VARCHAR
);
COMMENT ON TABLE cases IS 'One row per case: a train at one speed on one track, soil and unevenness';
COMMENT ON COLUMN cases.case_id IS 'Identity of the physics of the case, whatever approach computes it';
COMMENT ON COLUMN cases.soil IS 'Name of the soil';
COMMENT ON COLUMN cases.track IS 'Name of the track';
COMMENT ON COLUMN cases.train IS 'Name of the train';
COMMENT ON COLUMN cases.unevenness IS 'Name of the unevenness';
COMMENT ON COLUMN cases.speed_kmh IS 'Train speed, km/h';
COMMENT ON COLUMN cases.soil_id IS 'Soil of this case, see soils';
COMMENT ON COLUMN cases.track_id IS 'Track of this case, see tracks';
COMMENT ON COLUMN cases.train_id IS 'Train of this case, see trains';
COMMENT ON COLUMN cases.unevenness_id IS 'Unevenness of this case, see unevenness';

CREATE TABLE units (
    unit_id VARCHAR NOT NULL, kind VARCHAR, run_id VARCHAR, model_version VARCHAR, host VARCHAR, host_class VARCHAR,
    worker VARCHAR, attempt INTEGER, started TIMESTAMP, finished TIMESTAMP
);
COMMENT ON TABLE units IS 'One row per committed unit of work: a result in the store with its commit record';
COMMENT ON COLUMN units.unit_id IS 'Identity of the unit: its physical inputs and the version of the model';
COMMENT ON COLUMN units.kind IS 'Kind of unit: fit, transfer, receptance, line_integrals or spectra';
COMMENT ON COLUMN units.run_id IS 'Run that computed it, see runs';
COMMENT ON COLUMN units.model_version IS 'Version of the physical model';
COMMENT ON COLUMN units.host IS 'Machine that computed it';
COMMENT ON COLUMN units.host_class IS 'Kind of machine that computed it';
COMMENT ON COLUMN units.worker IS 'Worker that computed it';
COMMENT ON COLUMN units.attempt IS 'Attempt that succeeded';
COMMENT ON COLUMN units.started IS 'Start, UTC';
COMMENT ON COLUMN units.finished IS 'End, UTC';

CREATE TABLE case_units (run_id VARCHAR NOT NULL, case_id VARCHAR NOT NULL, approach VARCHAR NOT NULL, unit_id VARCHAR NOT NULL, scope VARCHAR);
COMMENT ON TABLE case_units IS 'Which units of work each approach needs for each case; shared units stand under every approach that needs them';
COMMENT ON COLUMN case_units.run_id IS 'Run that asked, see runs';
COMMENT ON COLUMN case_units.case_id IS 'Case, see cases';
COMMENT ON COLUMN case_units.approach IS 'Approach of the prediction';
COMMENT ON COLUMN case_units.unit_id IS 'Unit, see units; without a row there it is missing';
COMMENT ON COLUMN case_units.scope IS 'What the unit depends on: ground (shared by every speed), speed, or case';

CREATE TABLE unit_costs (
    unit_id VARCHAR NOT NULL, run_id VARCHAR, kind VARCHAR, stage VARCHAR, wall_s DOUBLE, cpu_s DOUBLE, evaluations BIGINT,
    kernel_calls BIGINT, peak_rss_bytes BIGINT, bytes_written BIGINT, worker VARCHAR, host_class VARCHAR, attempt INTEGER
);
COMMENT ON TABLE unit_costs IS 'What each stage of each unit of work cost, compilation excluded';
COMMENT ON COLUMN unit_costs.unit_id IS 'Unit, see units';
COMMENT ON COLUMN unit_costs.run_id IS 'Run that computed it, see runs';
COMMENT ON COLUMN unit_costs.kind IS 'Kind of unit';
COMMENT ON COLUMN unit_costs.stage IS 'Stage of the computation';
COMMENT ON COLUMN unit_costs.wall_s IS 'Elapsed time, s';
COMMENT ON COLUMN unit_costs.cpu_s IS 'Processor time, s';
COMMENT ON COLUMN unit_costs.evaluations IS 'Values of a transfer function computed, one per frequency and wavenumber';
COMMENT ON COLUMN unit_costs.kernel_calls IS 'Calls of compiled kernels';
COMMENT ON COLUMN unit_costs.peak_rss_bytes IS 'Largest resident memory of the worker, byte';
COMMENT ON COLUMN unit_costs.bytes_written IS 'Written to the store, byte';
COMMENT ON COLUMN unit_costs.worker IS 'Worker that computed it';
COMMENT ON COLUMN unit_costs.host_class IS 'Kind of machine that computed it';
COMMENT ON COLUMN unit_costs.attempt IS 'Attempt that succeeded';

CREATE TABLE series (
    series_id INTEGER NOT NULL, case_id VARCHAR NOT NULL, approach VARCHAR NOT NULL, contribution VARCHAR, quantity VARCHAR,
    receiver VARCHAR, offset_m DOUBLE, averaging VARCHAR, run_id VARCHAR, model_version VARCHAR, unit_id VARCHAR
);
COMMENT ON TABLE series IS 'One row per narrow-band spectrum in psd_lines; the view psd joins both';
COMMENT ON COLUMN series.series_id IS 'Number of the spectrum';
COMMENT ON COLUMN series.case_id IS 'Case, see cases';
COMMENT ON COLUMN series.approach IS 'Approach of the prediction';
COMMENT ON COLUMN series.contribution IS 'dynamic, quasi-static or total';
COMMENT ON COLUMN series.quantity IS 'wheel_rail_force or velocity';
COMMENT ON COLUMN series.receiver IS 'axle-1 (leads) to axle-M, rail or ground';
COMMENT ON COLUMN series.offset_m IS 'Distance of a ground receiver from the track centre, m; NULL elsewhere';
COMMENT ON COLUMN series.averaging IS 'line: over the whole line; train: over the length of the train';
COMMENT ON COLUMN series.run_id IS 'Run that computed it, see runs';
COMMENT ON COLUMN series.model_version IS 'Version of the physical model';
COMMENT ON COLUMN series.unit_id IS 'Unit it comes from, see units';

CREATE TABLE psd_lines (series_id INTEGER NOT NULL, frequency_hz DOUBLE, value DOUBLE);
COMMENT ON TABLE psd_lines IS 'Lines of the narrow-band spectra; ask the view psd, which names them';
COMMENT ON COLUMN psd_lines.series_id IS 'Spectrum, see series';
COMMENT ON COLUMN psd_lines.frequency_hz IS 'Frequency, Hz';
COMMENT ON COLUMN psd_lines.value IS 'One-sided density: (m/s)^2/Hz for velocity, N^2/Hz for wheel_rail_force';

CREATE TABLE bands (
    case_id VARCHAR NOT NULL, approach VARCHAR NOT NULL, contribution VARCHAR, quantity VARCHAR, receiver VARCHAR,
    offset_m DOUBLE, averaging VARCHAR, band_hz DOUBLE, mean_square DOUBLE, extrapolated_share DOUBLE, run_id VARCHAR,
    model_version VARCHAR, unit_id VARCHAR
);
COMMENT ON TABLE bands IS 'Mean squares in one-third octaves of IEC 61260-1, base 10';
COMMENT ON COLUMN bands.case_id IS 'Case, see cases';
COMMENT ON COLUMN bands.approach IS 'Approach of the prediction';
COMMENT ON COLUMN bands.contribution IS 'dynamic, quasi-static or total';
COMMENT ON COLUMN bands.quantity IS 'wheel_rail_force or velocity';
COMMENT ON COLUMN bands.receiver IS 'axle-1 (leads) to axle-M, rail or ground';
COMMENT ON COLUMN bands.offset_m IS 'Distance of a ground receiver from the track centre, m; NULL elsewhere';
COMMENT ON COLUMN bands.averaging IS 'line: over the whole line; train: over the length of the train';
COMMENT ON COLUMN bands.band_hz IS 'Exact midband frequency 10^(n/10), Hz';
COMMENT ON COLUMN bands.mean_square IS 'Mean square in the band: (m/s)^2 for velocity, N^2 for wheel_rail_force';
COMMENT ON COLUMN bands.extrapolated_share IS 'Share (0 to 1) of the unevenness behind this band that lies outside its form''s range of validity';
COMMENT ON COLUMN bands.run_id IS 'Run that computed it, see runs';
COMMENT ON COLUMN bands.model_version IS 'Version of the physical model';
COMMENT ON COLUMN bands.unit_id IS 'Unit it comes from, see units';

CREATE TABLE receptances (
    soil VARCHAR, track VARCHAR, speed_kmh DOUBLE, distance_m DOUBLE, frequency_hz DOUBLE, receptance_re DOUBLE,
    receptance_im DOUBLE, soil_id VARCHAR, track_id VARCHAR, run_id VARCHAR, model_version VARCHAR, unit_id VARCHAR
);
COMMENT ON TABLE receptances IS 'Rail receptance under the load; receptances between axles are in the store';
COMMENT ON COLUMN receptances.soil IS 'Name of the soil';
COMMENT ON COLUMN receptances.track IS 'Name of the track';
COMMENT ON COLUMN receptances.speed_kmh IS 'Speed of the load, km/h; 0 is the standing load';
COMMENT ON COLUMN receptances.distance_m IS 'Distance ahead of the load, m; the smallest of the unit, which is 0';
COMMENT ON COLUMN receptances.frequency_hz IS 'Own frequency of the load, Hz';
COMMENT ON COLUMN receptances.receptance_re IS 'Real part, m/N';
COMMENT ON COLUMN receptances.receptance_im IS 'Imaginary part, m/N; time factor e^(+i omega t)';
COMMENT ON COLUMN receptances.soil_id IS 'Soil, see soils';
COMMENT ON COLUMN receptances.track_id IS 'Track, see tracks';
COMMENT ON COLUMN receptances.run_id IS 'Run that computed it, see runs';
COMMENT ON COLUMN receptances.model_version IS 'Version of the physical model';
COMMENT ON COLUMN receptances.unit_id IS 'Unit it comes from, see units';

CREATE TABLE unevenness_bands (unevenness VARCHAR, unevenness_id VARCHAR, wavelength_m DOUBLE, mean_square_m2 DOUBLE, extrapolated_share DOUBLE);
COMMENT ON TABLE unevenness_bands IS 'Unevenness of the rail in one-third octaves of wavelength';
COMMENT ON COLUMN unevenness_bands.unevenness IS 'Name of the unevenness';
COMMENT ON COLUMN unevenness_bands.unevenness_id IS 'Unevenness, see unevenness';
COMMENT ON COLUMN unevenness_bands.wavelength_m IS 'Midband wavelength, m';
COMMENT ON COLUMN unevenness_bands.mean_square_m2 IS 'Mean square of the profile in the band, m^2';
COMMENT ON COLUMN unevenness_bands.extrapolated_share IS 'Share (0 to 1) of it that lies outside the form''s range of validity';

CREATE TABLE failures (
    unit_id VARCHAR, kind VARCHAR, run_id VARCHAR, attempt INTEGER, worker VARCHAR, host VARCHAR, started TIMESTAMP,
    finished TIMESTAMP, error VARCHAR, traceback VARCHAR
);
COMMENT ON TABLE failures IS 'Units of work that raised, and committed ones whose arrays could not be read';
COMMENT ON COLUMN failures.unit_id IS 'Unit that failed';
COMMENT ON COLUMN failures.kind IS 'Kind of unit';
COMMENT ON COLUMN failures.run_id IS 'Run in which it failed, see runs';
COMMENT ON COLUMN failures.attempt IS 'Attempt that failed';
COMMENT ON COLUMN failures.worker IS 'Worker on which it failed';
COMMENT ON COLUMN failures.host IS 'Machine on which it failed';
COMMENT ON COLUMN failures.started IS 'Start, UTC';
COMMENT ON COLUMN failures.finished IS 'End, UTC';
COMMENT ON COLUMN failures.error IS 'Last line of the traceback';
COMMENT ON COLUMN failures.traceback IS 'Traceback';

-- What the names stand for. A name that meant something else in an earlier run has a row, and an id, for each meaning.

CREATE TABLE soils (soil_id VARCHAR NOT NULL, soil VARCHAR, base VARCHAR, layers INTEGER, definition VARCHAR);
COMMENT ON TABLE soils IS 'Grounds';
COMMENT ON COLUMN soils.soil_id IS 'Identity of name and definition';
COMMENT ON COLUMN soils.soil IS 'Name';
COMMENT ON COLUMN soils.base IS 'What lies under the layers: half-space or rigid';
COMMENT ON COLUMN soils.layers IS 'Number of layers, the half-space included';
COMMENT ON COLUMN soils.definition IS 'Everything that defines it, JSON in the units of a study file';

CREATE TABLE soil_layers (
    soil_id VARCHAR NOT NULL, soil VARCHAR, layer INTEGER, thickness_m DOUBLE, shear_speed_m_s DOUBLE,
    dilatational_speed_m_s DOUBLE, density_kg_m3 DOUBLE, loss_factor DOUBLE
);
COMMENT ON TABLE soil_layers IS 'Layers of the grounds';
COMMENT ON COLUMN soil_layers.soil_id IS 'Ground, see soils';
COMMENT ON COLUMN soil_layers.soil IS 'Name of the ground';
COMMENT ON COLUMN soil_layers.layer IS 'Number from the surface down, 1 is the top';
COMMENT ON COLUMN soil_layers.thickness_m IS 'Thickness, m; NULL for the half-space';
COMMENT ON COLUMN soil_layers.shear_speed_m_s IS 'Speed of shear waves, m/s';
COMMENT ON COLUMN soil_layers.dilatational_speed_m_s IS 'Speed of dilatational waves, m/s';
COMMENT ON COLUMN soil_layers.density_kg_m3 IS 'Density, kg/m^3';
COMMENT ON COLUMN soil_layers.loss_factor IS 'Hysteretic loss factor, twice the damping ratio';

CREATE TABLE tracks (
    track_id VARCHAR NOT NULL, track VARCHAR, form VARCHAR, rail_bending_stiffness_n_m2 DOUBLE, rail_mass_kg_m DOUBLE,
    rail_loss_factor DOUBLE, pad_stiffness_n_m2 DOUBLE, pad_loss_factor DOUBLE, contact_width_m DOUBLE, sleeper_mass_kg_m DOUBLE,
    slab_bending_stiffness_n_m2 DOUBLE, slab_mass_kg_m DOUBLE, slab_loss_factor DOUBLE, definition VARCHAR
);
COMMENT ON TABLE tracks IS 'Tracks; all values for both rails together';
COMMENT ON COLUMN tracks.track_id IS 'Identity of name and definition';
COMMENT ON COLUMN tracks.track IS 'Name';
COMMENT ON COLUMN tracks.form IS 'ballasted or slab';
COMMENT ON COLUMN tracks.rail_bending_stiffness_n_m2 IS 'Bending stiffness of the rails, N m^2';
COMMENT ON COLUMN tracks.rail_mass_kg_m IS 'Mass of the rails, kg/m';
COMMENT ON COLUMN tracks.rail_loss_factor IS 'Loss factor of the rails';
COMMENT ON COLUMN tracks.pad_stiffness_n_m2 IS 'Stiffness of the rail pads, N/m^2';
COMMENT ON COLUMN tracks.pad_loss_factor IS 'Loss factor of the rail pads';
COMMENT ON COLUMN tracks.contact_width_m IS 'Width over which the track presses on the ground, m';
COMMENT ON COLUMN tracks.sleeper_mass_kg_m IS 'Mass of the sleepers, kg/m; NULL for a slab';
COMMENT ON COLUMN tracks.slab_bending_stiffness_n_m2 IS 'Bending stiffness of the slab, N m^2';
COMMENT ON COLUMN tracks.slab_mass_kg_m IS 'Mass of the slab, kg/m';
COMMENT ON COLUMN tracks.slab_loss_factor IS 'Loss factor of the slab';
COMMENT ON COLUMN tracks.definition IS 'Everything that defines it, JSON in the units of a study file';

CREATE TABLE track_layers (
    track_id VARCHAR NOT NULL, track VARCHAR, layer INTEGER, stiffness_n_m2 DOUBLE, mass_kg_m DOUBLE, loss_factor DOUBLE
);
COMMENT ON TABLE track_layers IS 'Layers between the sleepers or the slab and the ground';
COMMENT ON COLUMN track_layers.track_id IS 'Track, see tracks';
COMMENT ON COLUMN track_layers.track IS 'Name of the track';
COMMENT ON COLUMN track_layers.layer IS 'Number from the top down; 0 is the mat under a slab, 1 the ballast';
COMMENT ON COLUMN track_layers.stiffness_n_m2 IS 'Vertical stiffness per length of track, N/m^2';
COMMENT ON COLUMN track_layers.mass_kg_m IS 'Mass, kg/m';
COMMENT ON COLUMN track_layers.loss_factor IS 'Hysteretic loss factor';

CREATE TABLE trains (train_id VARCHAR NOT NULL, train VARCHAR, vehicles INTEGER, axles INTEGER, length_m DOUBLE, definition VARCHAR);
COMMENT ON TABLE trains IS 'Trains';
COMMENT ON COLUMN trains.train_id IS 'Identity of name and definition';
COMMENT ON COLUMN trains.train IS 'Name';
COMMENT ON COLUMN trains.vehicles IS 'Number of vehicles';
COMMENT ON COLUMN trains.axles IS 'Number of axles';
COMMENT ON COLUMN trains.length_m IS 'Length over all vehicles, m';
COMMENT ON COLUMN trains.definition IS 'Everything that defines it, JSON in the units of a study file';

CREATE TABLE vehicles (
    train_id VARCHAR NOT NULL, train VARCHAR, vehicle INTEGER, car_mass_kg DOUBLE, car_pitch_inertia_kg_m2 DOUBLE, bogie_mass_kg DOUBLE,
    bogie_pitch_inertia_kg_m2 DOUBLE, wheelset_mass_kg DOUBLE, primary_stiffness_n_m DOUBLE, primary_damping_n_s_m DOUBLE,
    secondary_stiffness_n_m DOUBLE, secondary_damping_n_s_m DOUBLE, axle_spacing_m DOUBLE, bogie_spacing_m DOUBLE, length_m DOUBLE,
    axle_load_n DOUBLE, contact_stiffness_per_wheel_n_m DOUBLE
);
COMMENT ON TABLE vehicles IS 'Vehicles of the trains';
COMMENT ON COLUMN vehicles.train_id IS 'Train, see trains';
COMMENT ON COLUMN vehicles.train IS 'Name of the train';
COMMENT ON COLUMN vehicles.vehicle IS 'Number from the head of the train, 1 leads';
COMMENT ON COLUMN vehicles.car_mass_kg IS 'Mass of the car body, kg';
COMMENT ON COLUMN vehicles.car_pitch_inertia_kg_m2 IS 'Pitching inertia of the car body, kg m^2';
COMMENT ON COLUMN vehicles.bogie_mass_kg IS 'Mass of one bogie frame, kg';
COMMENT ON COLUMN vehicles.bogie_pitch_inertia_kg_m2 IS 'Pitching inertia of one bogie frame, kg m^2';
COMMENT ON COLUMN vehicles.wheelset_mass_kg IS 'Unsprung mass of one wheelset, kg';
COMMENT ON COLUMN vehicles.primary_stiffness_n_m IS 'Primary suspension of one axle, N/m';
COMMENT ON COLUMN vehicles.primary_damping_n_s_m IS 'Viscous damping of one axle''s primary suspension, N s/m';
COMMENT ON COLUMN vehicles.secondary_stiffness_n_m IS 'Secondary suspension of one bogie, N/m';
COMMENT ON COLUMN vehicles.secondary_damping_n_s_m IS 'Viscous damping of one bogie''s secondary suspension, N s/m';
COMMENT ON COLUMN vehicles.axle_spacing_m IS 'Distance between the axles of a bogie, m';
COMMENT ON COLUMN vehicles.bogie_spacing_m IS 'Distance between the bogie centres, m';
COMMENT ON COLUMN vehicles.length_m IS 'Length over the couplings, m';
COMMENT ON COLUMN vehicles.axle_load_n IS 'Static load of one axle, N';
COMMENT ON COLUMN vehicles.contact_stiffness_per_wheel_n_m IS 'Linearised Hertz spring of one wheel, N/m; an axle has two';

CREATE TABLE axles (
    train_id VARCHAR NOT NULL, train VARCHAR, receiver VARCHAR, vehicle INTEGER, behind_first_axle_m DOUBLE, axle_load_n DOUBLE
);
COMMENT ON TABLE axles IS 'Axles of the trains';
COMMENT ON COLUMN axles.train_id IS 'Train, see trains';
COMMENT ON COLUMN axles.train IS 'Name of the train';
COMMENT ON COLUMN axles.receiver IS 'Name of the axle in bands and psd: axle-1 leads';
COMMENT ON COLUMN axles.vehicle IS 'Number of its vehicle from the head of the train, 1 leads';
COMMENT ON COLUMN axles.behind_first_axle_m IS 'Distance behind the leading axle, m';
COMMENT ON COLUMN axles.axle_load_n IS 'Static load, N';

CREATE TABLE unevenness (unevenness_id VARCHAR NOT NULL, unevenness VARCHAR, form VARCHAR, definition VARCHAR);
COMMENT ON TABLE unevenness IS 'Unevenness of the rail';
COMMENT ON COLUMN unevenness.unevenness_id IS 'Identity of name and definition';
COMMENT ON COLUMN unevenness.unevenness IS 'Name';
COMMENT ON COLUMN unevenness.form IS 'Analytic form, power law or table';
COMMENT ON COLUMN unevenness.definition IS 'Everything that defines it, JSON in the units of a study file';
