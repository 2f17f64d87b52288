//! What a log has beside its samples is taken out on the way in: stamps that repeat, rows between two samples.

use super::recording::{Recording, places};
use super::stamps::{Repeats, repeats};
use super::{position_step, stale};

impl Recording {
    /// Lets stamps that repeat rise, or leaves out the rows that have them.
    ///
    /// # Errors
    ///
    /// What is wrong with stamps that no rounding makes.
    pub(super) fn mend_stamps(&mut self) -> Result<(), String> {
        let is_again = |row: usize| self.is_again(row);
        let found = repeats(&self.t_s, is_again).map_err(|row| {
            format!(
                "row {}: the time repeats for longer than rounding or packets of rows explain; it must rise",
                row + 1
            )
        })?;
        match found {
            Repeats::None => {}
            Repeats::WrittenTwice(again) => {
                let rows: Vec<usize> = (0..self.rows()).filter(|row| again.binary_search(row).is_err()).collect();
                self.keep(&rows);
                self.mended
                    .push(format!("{} repeat the row before with its time, and are left out", rows_of(again.len())));
            }
            Repeats::Spread(t_s, count) => {
                self.mended.push(format!(
                    "the time repeats in {}, as it does where it is rounded: those rows are spread evenly to the next time",
                    places(count)
                ));
                let behind = self.rows() - t_s.len();
                if behind > 0 {
                    self.keep(&(0..t_s.len()).collect::<Vec<_>>());
                    self.mended
                        .push(format!("the last {} are the one before again, and are left out", rows_of(behind)));
                }
                self.t_s = t_s;
            }
        }
        Ok(())
    }

    /// Leaves out rows in which a slower channel's position is written again. What is commanded from a sample to the next is the mean
    /// of its rows, which moves the axis by as much. A drive's own log has one sample a row.
    pub(super) fn mend_stale_rows(&mut self) {
        let of_the_drive = self.mode.is_some() || self.seq.is_some() || self.counts.is_some();
        if of_the_drive || self.field_cmd_kv_mm.is_some() {
            return;
        }
        let step = || position_step(&self.position).unwrap_or(0.0);
        let Some(samples) = stale::samples(&self.position, step) else { return };
        let rows = self.rows();
        let mean = |(from, to): (usize, usize)| {
            let until_s = |row: usize| self.t_s.get(row + 1).map_or(0.0, |next| next - self.t_s[row]);
            let (area, time_s) = (from..to).fold((0.0, 0.0), |(area, time_s), row| {
                (area + self.effort_cmd[row] * until_s(row), time_s + until_s(row))
            });
            let mean = area / time_s;
            if mean.is_finite() { mean } else { self.effort_cmd[from] }
        };
        let ends = samples.iter().skip(1).copied().chain([rows]);
        let effort_cmd = samples.iter().copied().zip(ends).map(mean).collect();
        self.keep(&samples);
        self.effort_cmd = effort_cmd;
        self.mended.push(format!(
            "the position is a new one in {} of {rows} rows: the others hold the sample before and are left out, and what is \
             commanded meanwhile is taken as its mean",
            samples.len()
        ));
    }

    /// Whether a row is the one before it, in every column of the format.
    fn is_again(&self, row: usize) -> bool {
        fn same<T: PartialEq>(column: Option<&Vec<T>>, row: usize) -> bool {
            column.is_none_or(|values| values[row] == values[row - 1])
        }
        let required = [&self.t_s, &self.position, &self.effort_cmd].map(Some);
        let optional = [
            &self.reference,
            &self.field_cmd_kv_mm,
            &self.velocity,
            &self.effort_meas,
            &self.field_meas_kv_mm,
            &self.temperature_c,
        ];
        required.into_iter().chain(optional.map(Option::as_ref)).all(|column| same(column, row))
            && same(self.mode.as_ref(), row)
            && same(self.seq.as_ref(), row)
            && same(self.fault.as_ref(), row)
            && same(self.counts.as_ref(), row)
    }

    /// Leaves out all rows but these, which rise.
    fn keep(&mut self, rows: &[usize]) {
        fn keep<T: Clone>(values: &mut Vec<T>, rows: &[usize]) {
            *values = rows.iter().map(|row| values[*row].clone()).collect();
        }
        fn keep_each<'a, T: Clone + 'a>(columns: impl IntoIterator<Item = &'a mut Option<Vec<T>>>, rows: &[usize]) {
            columns.into_iter().flatten().for_each(|values| keep(values, rows));
        }
        for values in [&mut self.t_s, &mut self.position, &mut self.effort_cmd] {
            keep(values, rows);
        }
        let real = [
            &mut self.reference,
            &mut self.field_cmd_kv_mm,
            &mut self.velocity,
            &mut self.effort_meas,
            &mut self.field_meas_kv_mm,
            &mut self.temperature_c,
        ];
        keep_each(real, rows);
        keep_each([&mut self.mode], rows);
        keep_each([&mut self.seq], rows);
        keep_each([&mut self.fault], rows);
        keep_each([&mut self.counts], rows);
        let extra = self.extra.iter_mut().filter(|(_, cells)| !cells.is_empty());
        extra.for_each(|(_, cells)| keep(cells, rows));
    }
}

fn rows_of(count: usize) -> String {
    format!("{count} row{}", if count == 1 { "" } else { "s" })
}
